// The operator's hand: words to the flight, with the token of the address. What cannot be undone takes two steps.

/** Each button: its words, and whether a second step asks first. */
const FOR_ALL = [
  { verb: "pause", label: "Pause", title: "All hold where they are" },
  { verb: "resume", label: "Resume", title: "All fly on" },
  { verb: "abort", label: "Abort\u2026", asks: "The flight ends for all vehicles. They shall", choices: [
    ["abort", "end as planned"], ["abort loiter", "loiter"], ["abort return", "return"], ["abort land", "land"]] },
];
const FOR_ONE = [
  { verb: "drop N", label: "Drop", asks: "is flown no more, and holds where it is.", choices: [["drop N", "Drop it"]] },
  { verb: "take N", label: "Take back", title: "It is flown again" },
  { verb: "pause N", label: "Pause", title: "It holds where it is" },
  { verb: "resume N", label: "Resume", title: "It flies on" },
  { verb: "abort N", label: "End\u2026", asks: "is flown no more. It shall", choices: [
    ["loiter N", "loiter"], ["return N", "return"], ["land N", "land"]] },
];

export class Operator {
  constructor(page, say) {
    this.page = page;
    this.say = say;
    this.waiting = new Map();
    this.next = 1;
    this.may = false;
    this.one = [];
    this.numbers = []; // of the vehicles that are selected
  }

  /** Makes the buttons that the flight has words for. */
  offer(verbs, may) {
    this.may = may;
    const has = (verb) => verbs.includes(verb);
    const own = (buttons) => buttons
      .map((button) => ({ ...button, choices: button.choices?.filter(([words]) => has(words)) }))
      .filter((button) => button.choices ? button.choices.length : has(button.verb));
    this.page.all.replaceChildren(...own(FOR_ALL).map((button) => this.button(button, () => [null])));
    this.one = own(FOR_ONE);
    const isWatching = verbs.length && !may;
    this.page.note.textContent = isWatching ? "Watching only: the printed address with its token gives orders." : "";
    for (const button of this.page.all.children) button.disabled = !may;
    // A vehicle may be selected before the program has told that this page may give orders, and while a scene changes.
    this.select(this.numbers);
  }

  /** Makes the buttons for the vehicles of these numbers. */
  select(numbers) {
    this.numbers = numbers;
    const buttons = numbers.length ? this.one.map((button) => this.button(button, () => numbers)) : [];
    buttons.forEach((button) => { button.disabled = !this.may; });
    this.page.one.replaceChildren(...buttons);
  }

  button({ verb, label, title, asks, choices }, whose) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = label;
    button.dataset.verb = verb;
    if (title) button.title = title;
    button.className = asks ? "grave" : "";
    button.addEventListener("click", () => asks ? this.ask(asks, choices, whose()) : this.order(verb, whose()));
    return button;
  }

  /** The second step. */
  ask(asks, choices, numbers) {
    const dialog = this.page.dialog;
    const isMany = numbers.length > 6;
    const names = isMany ? `${numbers.length} vehicles: each ` : `Vehicle ${numbers.join(", ")} `;
    const name = numbers[0] === null ? "" : names;
    dialog.querySelector("p").textContent = name + asks;
    const buttons = choices.map(([words, label]) => {
      const button = document.createElement("button");
      button.type = "button";
      button.className = "grave";
      button.textContent = label;
      button.dataset.say = words;
      button.addEventListener("click", () => { dialog.close(); this.order(words, numbers); });
      return button;
    });
    const cancel = document.createElement("button");
    cancel.type = "button";
    cancel.textContent = "Cancel";
    cancel.addEventListener("click", () => dialog.close());
    dialog.querySelector(".choices").replaceChildren(...buttons, cancel);
    dialog.showModal();
    cancel.focus();
  }

  order(words, numbers) {
    for (const number of numbers) {
      const text = number === null ? words : words.replace("N", number);
      const id = this.next++;
      this.waiting.set(id, text);
      this.show(`${text} \u2026`);
      if (!this.say({ say: text, id })) this.show(`${text}: not sent, the program is not there`);
    }
  }

  answered({ id, is_done: done, text }) {
    const said = this.waiting.get(id) ?? "";
    this.waiting.delete(id);
    this.show(`${said}: ${text}`, !done);
  }

  show(text, isRefused = false) {
    this.page.answer.textContent = text;
    this.page.answer.classList.toggle("refused", isRefused);
  }
}
