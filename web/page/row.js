// A row of buttons that is one stop of the Tab key: arrow keys, Home and End move within the row.

const buttonsOf = (row) => [...row.querySelectorAll("button:not([hidden])")];

/** Make Tab stop at one button of the row alone. */
export function stopAt(row, chosen) {
  for (const button of buttonsOf(row)) button.tabIndex = button === chosen ? 0 : -1;
}

/** onMove(button): called when a key has moved the focus to a button. */
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
