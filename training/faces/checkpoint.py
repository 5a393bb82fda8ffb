"""Checkpoints of a training run: the net, the running average of its weights, the optimizer."""

from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn


def rate_at(step: int, steps: int, highest: float, warm_up: int) -> float:
    """The learning rate: rises for warm_up steps, stays, and falls to almost 0 in the last 40 %."""
    return highest * min(1, (step + 1) / warm_up, 2.5 * (1 - step / steps) + 0.005)


class Checkpoint:
    """A file that a run resumes from: weights, their average, the optimizer's state, the step."""

    def __init__(
        self, path: Path, net: nn.Module, optimizer: torch.optim.Optimizer, decay: float
    ) -> None:
        """decay: of the running average, per step. The file's folder is made if it is missing."""
        path.parent.mkdir(parents=True, exist_ok=True)
        self.path, self.net, self.optimizer, self.decay = path, net, optimizer, decay
        self.average = AveragedModel(
            net, multi_avg_fn=get_ema_multi_avg_fn(decay), use_buffers=True
        )
        self.step = 0

    def resume(self, steps: int | None = None) -> None:
        """Resume from the file, if there is one.

        steps: the length of the whole run; the command ends with a message when no step is left.
        """
        if not self.path.exists():
            return
        saved = saved_in(self.path)
        self.net.load_state_dict(saved["net"])
        self.average.load_state_dict(saved["average"])
        self.optimizer.load_state_dict(saved["optimizer"])
        self.step = saved["step"]
        if steps is not None and self.step >= steps:
            raise SystemExit(
                f"{self.path} is finished: it has {self.step} steps, and {steps} were asked for; "
                "move it away to start again, or ask for more samples"
            )
        print(f"{self.path} is resumed at step {self.step}: to begin anew, move it away")

    def start_from(self, path: Path) -> None:
        """Start at step 0 from the averaged weights of another run, with a new optimizer."""
        average = saved_in(path)["average"]
        self.average.load_state_dict(average)
        self.net.load_state_dict(self.average.module.state_dict())
        self.average.n_averaged.zero_()

    def learn(self, loss: Tensor, rate: float, clip: float) -> None:
        """One step of the optimizer, with the running average.

        clip: the largest norm of the gradient.
        """
        for group in self.optimizer.param_groups:
            group["lr"] = rate
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(self.net.parameters(), clip)
        self.optimizer.step()
        self._average()

    def _average(self) -> None:
        """Update the running average, which forgets faster in the first steps."""
        self.step += 1
        young = self.step < 1 / (1 - self.decay)
        decay = min(self.decay, self.step / (self.step + 10)) if young else self.decay
        self.average.multi_avg_fn = get_ema_multi_avg_fn(decay)
        self.average.update_parameters(self.net)

    def save(self, config: tuple[str, int]) -> None:
        """Write the file. config: the net's name, and the number of its points or numbers."""
        state = {
            "net": self.net.state_dict(),
            "average": self.average.state_dict(),
            "optimizer": self.optimizer.state_dict(),
            "step": self.step,
            "config": config,
        }
        torch.save(state, self.path.with_suffix(".part"))
        self.path.with_suffix(".part").rename(self.path)


def saved_in(path: Path) -> dict[str, Any]:
    """What torch.save wrote, on the CPU, whatever device it was saved from."""
    saved: dict[str, Any] = torch.load(path, map_location="cpu", weights_only=True)
    return saved


def averaged_weights(path: Path) -> dict[str, Tensor]:
    """The averaged weights of a checkpoint, with the keys of the net itself."""
    average = saved_in(path)["average"]
    return {k.removeprefix("module."): v for k, v in average.items() if k != "n_averaged"}
