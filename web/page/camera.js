// The choice of the camera and its size.

import { addressOf, ask, NO_ANSWER } from "./ask.js";
import { byId, el } from "./elements.js";

const OWN_SIZE = "the file’s own size";

const section = byId("camera");

/**
 * Show the cameras and sizes to choose from. session: its name.  onOwner(isOwner): is called with
 * whether this page is on the camera's machine.  onError(text): shows a refusal; "" clears it.
 */
export async function showCameras(session, onOwner, onError) {
  let choices;
  try {
    const response = await ask(addressOf("/camera", session));
    if (!response.ok) return;
    choices = await response.json();
  } catch {
    section.hidden = true; // the connection is lost, and the next hello asks again
    return;
  }
  onOwner(choices.is_owner);
  show(choices, session, onError);
}

function show(choices, session, onError) {
  const { names = [], name, sizes = [], size } = choices;
  section.hidden = names.length < 2 && size == null;
  if (section.hidden) return; // a run without cameras, or a page on another machine
  const camera = choice("Camera", names.includes(name) ? names : [name, ...names], name);
  const sizeChoice = choice("Size", sizes.includes(size) ? sizes : [size ?? "", ...sizes], size ?? "");
  const put = async ({ target }) => {
    onError("");
    section.setAttribute("aria-busy", "true");
    const chosen = {
      // "": as it is now, since another page may have chosen something else meanwhile
      name: target.name === "camera" ? target.value : "",
      size: target.name === "size" ? target.value : "",
    };
    try {
      const response = await ask(addressOf("/camera", session, chosen), { method: "POST" });
      const answer = await response.json();
      if (!response.ok) onError(answer.error);
      show(response.ok ? answer : choices, session, onError);
    } catch {
      show(choices, session, onError);
      onError(`The camera could not be changed: ${NO_ANSWER}`);
    }
    section.setAttribute("aria-busy", "false");
  };
  for (const one of [camera, sizeChoice]) one.lastElementChild.addEventListener("change", put);
  const focused = section.contains(document.activeElement) && document.activeElement.name;
  section.replaceChildren(camera, sizeChoice);
  if (focused) section.querySelector(`[name=${focused}]`).focus();
}

function choice(title, values, chosen) {
  const options = values.map((value) => el("option", { value }, value.split("/").pop() || OWN_SIZE));
  const select = el("select", { name: title.toLowerCase() }, ...options);
  select.value = chosen;
  return el("label", {}, el("small", {}, title), select);
}
