"""The page of results of a batch: one HTML file that needs nothing else."""

import base64
import html
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from urllib.parse import quote

from makeup_video.pipeline.batch.job import Done, Job, JobLook, Result
from makeup_video.pipeline.errors import MakeupVideoError, UsageError, option
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.files.relative import seen_from

_MARK = '<meta name="generator" content="makeup-video batch">'
_HEAD = f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8">{_MARK}
<meta name="viewport" content="width=device-width">
<title>makeup-video batch</title>
<style>
body {{ font: 15px/1.4 system-ui, sans-serif; margin: 2em auto; max-width: 75em; padding: 0 1em }}
section {{ border-top: 1px solid #8886; padding: .8em 0 }}
h2 {{ font-size: 1em; margin: 0 0 .5em; overflow-wrap: anywhere }}
div {{ display: flex; flex-wrap: wrap; gap: .8em }}
figure {{ margin: 0; width: 240px }}
img {{ display: block; max-width: 240px }}
figcaption {{ overflow-wrap: anywhere; font-size: .85em }}
small {{ display: block; opacity: .75 }}
.failed {{ color: #c22 }}
@media (prefers-color-scheme: dark) {{ body {{ background: #181818; color: #ddd }}
  a {{ color: #8bf }} .failed {{ color: #f77 }} }}
</style></head><body>
"""


def check_page(path: Path, *, overwrite: bool) -> None:
    """Raises UsageError when `path` is a file other than a page of a batch, unless overwrite."""
    if overwrite or not path.exists():
        return
    with write_errors(path), path.open("rb") as file:
        if _MARK.encode() not in file.read(len(_HEAD)):
            raise UsageError(
                f"{path}, where the page of results goes, is another page: add "
                f"{option('overwrite', True)} to overwrite it, or choose another folder"
            )


def write_page(
    path: Path,
    jobs: Sequence[Job],
    results: Mapping[str, Result],
    say: Callable[[MakeupVideoError], str] = str,
) -> None:
    """Write a section for each input with the pictures before and after, times and warnings.

    results: by output; an output that has none is left out.  say: puts an error into words.
    Raises OutputError.
    """
    with OutputFile(path, None, overwrite=True) as target, write_errors(path):
        # file names may not be valid UTF-8
        target.own_path.write_text(
            page_of(path.parent, jobs, results, say), "utf-8", "backslashreplace"
        )


def page_of(
    folder: Path,
    jobs: Sequence[Job],
    results: Mapping[str, Result],
    say: Callable[[MakeupVideoError], str] = str,
) -> str:
    """The text of a page that lies in a folder; its links are relative to it."""
    done = sum(isinstance(one, Done) for one in results.values())
    sections = "".join(_section(folder, job, results, say) for job in jobs)
    failed = f", {len(results) - done} failed" if done < len(results) else ""
    title = f"<h1>{done} of {len(results)} outputs done{failed}</h1>\n"
    return f"{_HEAD}{title}{sections}</body></html>\n"


def _section(
    folder: Path,
    job: Job,
    results: Mapping[str, Result],
    say: Callable[[MakeupVideoError], str],
) -> str:
    found = [(look, results[look.output]) for look in job.looks if look.output in results]
    if not found:
        return ""
    before = next((one.before for _, one in found if isinstance(one, Done) and one.before), None)
    figures = [_figure(_picture(before), f"{_link(folder, job.source)}<small>before</small>")]
    figures += [_of_look(folder, look, result, say) for look, result in found]
    name = html.escape(Path(job.source).name)
    return f"<section><h2>{name}</h2><div>{''.join(figures)}</div></section>\n"


def _of_look(
    folder: Path, look: JobLook, result: Result, say: Callable[[MakeupVideoError], str]
) -> str:
    name = html.escape(look.name)
    if isinstance(result, Done):
        facts = [name, result.size_in_words]
        facts += [f"{result.seconds:.1f} s"] if result.seconds else []
        notes = "".join(f"<small>{html.escape(one)}</small>" for one in result.warnings)
        text = f"{_link(folder, look.output)}<small>{', '.join(facts)}</small>{notes}"
        return _figure(_picture(result.after), text)
    error = html.escape(say(result.error))
    return _figure("", f'{name}<small class="failed">{error}</small>')


def _figure(picture: str, text: str) -> str:
    return f"<figure>{picture}<figcaption>{text}</figcaption></figure>"


def _picture(jpeg: bytes | None) -> str:
    if jpeg is None:
        return ""
    return f'<img alt="" src="data:image/jpeg;base64,{base64.b64encode(jpeg).decode()}">'


def _link(folder: Path, file: str) -> str:
    path = seen_from(folder, file)
    is_far = path.is_absolute()  # on another drive
    link = path.as_uri() if is_far else quote(path.as_posix(), errors="surrogateescape")
    return f'<a href="{link}">{html.escape(Path(file).name)}</a>'
