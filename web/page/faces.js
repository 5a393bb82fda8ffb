// A photo with several faces: the visitor chooses one.

import { byId, el } from "./elements.js";

const dialog = byId("faces");
const picture = dialog.querySelector(".picture");

/**
 * Ask the visitor which face to read. error, picture, faces: as in the answer of /photo.  signal:
 * aborted when a newer photo is given. Resolves to the face's number, or to null for no face.
 */
export function chooseFace({ error, picture: jpeg, faces }, signal) {
  dialog.querySelector("h2").textContent = error;
  const image = el("img", { alt: "", draggable: false, src: URL.createObjectURL(blobOf(jpeg)) });
  return new Promise((resolve) => {
    const buttons = faces.map((face) => {
      const label = `Face ${face.number}`; // the command uses the same numbers
      const button = el("button", { type: "button", "aria-label": label }, el("b", {}, face.number));
      for (const side of ["left", "top", "width", "height"])
        button.style[side] = `${100 * face[side]}%`;
      button.onclick = () => dialog.close(String(face.number));
      return button;
    });
    const close = () => dialog.close();
    signal.addEventListener("abort", close);
    dialog.onclose = () => {
      signal.removeEventListener("abort", close);
      URL.revokeObjectURL(image.src);
      resolve(dialog.returnValue === "" ? null : Number(dialog.returnValue));
    };
    picture.replaceChildren(image, ...buttons);
    dialog.returnValue = "";
    dialog.showModal();
  });
}

function blobOf(base64) {
  const bytes = Uint8Array.from(atob(base64), (letter) => letter.charCodeAt(0));
  return new Blob([bytes], { type: "image/jpeg" });
}
