// A row of buttons that is one stop of the Tab key: arrow keys, Home and End move within the row.

const buttonsOf = (row) => [...row.querySelectorAll("button:not([hidden])")];

/** Let the Tab key stop only at one button of the row. */
export function stopAt(row, chosen) {
  for (const button of buttonsOf(row)) button.tabIndex = button === chosen ? 0 : -1;
}

/** Make these the buttons of the row. A button is moved only if needed, so that the focus stays. */
export function putButtons(row, buttons) {
  const hadFocus = row.contains(document.activeElement) ? document.activeElement : null;
  for (const button of [...row.children]) if (!buttons.includes(button)) button.remove();
  buttons.forEach((button, at) => {
    if (row.children[at] !== button) row.insertBefore(button, row.children[at] ?? null);
  });
  if (hadFocus === null || hadFocus === document.activeElement) return;
  const next = hadFocus.isConnected ? hadFocus : row.firstElementChild;
  next?.focus({ preventScroll: true });
}

/** Let keys move the focus in the row. onMove(button): called when a key has moved the focus. */
export function moveByKeys(row, onMove = () => {}) {
  row.addEventListener("focusin", (event) => stopAt(row, event.target.closest("button")));
  row.addEventListener("keydown", (event) => {
    const buttons = buttonsOf(row);
    const at = buttons.indexOf(event.target);
    const to = {
      ArrowRight: (at + 1) % buttons.length,
      ArrowLeft: (at + buttons.length - 1) % buttons.length,
      Home: 0,
      End: buttons.length - 1,
    }[event.key];
    if (at < 0 || to === undefined) return;
    event.preventDefault();
    buttons[to].focus();
    onMove(buttons[to]);
  });
}
