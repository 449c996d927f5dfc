"use strict";
// Shows what the controller tells, as it tells it. All of it is put in as text: no name can become markup.

const at = (id) => document.getElementById(id);
const made = (kind, text, attributes = {}) => Object.assign(document.createElement(kind), { textContent: text }, attributes);
const SILENT_MS = 25_000;
let token = sessionStorage.getItem("token");
let views = "";
let hasCommands = null;
let heard = Date.now();

function show(news) {
  const { connection, status, rows, log, note } = news;
  at("name").textContent = status?.exhibit ?? "No plan";
  document.title = `${status?.exhibit ?? "No plan"} - Vitrine`;
  at("who").textContent = status ? `${status.port}, ${status.serial_number}, firmware ${status.firmware}` : "";
  showConnection(connection);
  for (const lamp of ["top", "bottom"]) {
    const level = status?.lamps[lamp].level ?? 0;
    at(lamp).value = level;
    document.querySelector(`output[for=${lamp}]`).value = status ? `${(100 * level).toFixed(1)} %` : "";
  }
  at("rows").replaceChildren(...rows.map(({ what, text, alarm }) => {
    const row = made("div", "", { className: alarm ? "alarm" : "" });
    row.append(made("dt", what), made("dd", text));
    return row;
  }));
  at("log").replaceChildren(...log.map(({ when, what }) => {
    const line = made("li", "");
    line.append(made("time", when), " ", made("span", what));
    return line;
  }));
  if (at("note").textContent !== note && note) at("note").textContent = note;
  hasCommands = news.has_commands;
  showCommands(news.views, connection.state === "there");
}

function showConnection({ state, away_s, why, remedy }) {
  const words = {
    looking: "looking for the controller",
    there: "connected",
    away: `away: ${why}${remedy ? `; ${remedy}` : ""}`,
  }[state];
  // Told again only when it has changed, so that it is not read aloud again and again.
  if (at("connection").textContent !== words) at("connection").textContent = words;
  at("since").textContent = state === "away" ? `for ${away_s} s` : "";
  at("connection").className = state;
  at("exhibit").classList.toggle("old", state !== "there");
}

function showCommands(names, there) {
  at("read-only").hidden = hasCommands !== false;
  at("unlock").hidden = !hasCommands || token !== null;
  at("buttons").hidden = !hasCommands || token === null;
  if (JSON.stringify(names) !== views) {
    views = JSON.stringify(names);
    at("views").replaceChildren(...names.map((name, view) => {
      const button = made("button", `Hold ${name}`);
      button.addEventListener("click", () => ask({ ask: "hold", view }));
      return button;
    }));
  }
  for (const button of at("buttons").querySelectorAll("button:not(#lock)")) button.disabled = !there;
}

// Whether it was granted.
async function post(path, key, what) {
  const headers = { "Content-Type": "application/json", Authorization: `Bearer ${key}` };
  try {
    const answer = await fetch(path, { method: "POST", headers, body: JSON.stringify(what) });
    if (answer.ok) return true;
    at("note").textContent = await answer.text();
    if (answer.status === 401) keep(null);
  } catch {
    at("note").textContent = "vitrine serve does not answer: nothing was asked";
  }
  return false;
}

const ask = (what) => post("/ask", token, what);

function keep(given) {
  token = given;
  if (given === null) sessionStorage.removeItem("token");
  else sessionStorage.setItem("token", given);
  at("unlock").hidden = token !== null;
  at("buttons").hidden = token === null;
}

at("unlock").addEventListener("submit", async (event) => {
  event.preventDefault();
  const given = at("token").value.trim();
  at("token").value = "";
  if (!/^[\x21-\x7e]+$/.test(given)) at("note").textContent = "this is not the access token";
  else if (await post("/unlock", given, {})) {
    at("note").textContent = "";
    keep(given);
  }
});
at("lock").addEventListener("click", () => keep(null));
for (const button of document.querySelectorAll("[data-ask]")) {
  button.addEventListener("click", () => ask({ ask: button.dataset.ask }));
}

const events = new EventSource("/events");
events.addEventListener("message", (event) => {
  heard = Date.now();
  show(JSON.parse(event.data));
});
events.addEventListener("error", () => showConnection({ state: "away", away_s: Math.round((Date.now() - heard) / 1000), why: "vitrine serve does not answer" }));
// A network that swallows everything ends no connection.
setInterval(() => {
  if (Date.now() - heard > SILENT_MS) showConnection({ state: "away", away_s: Math.round((Date.now() - heard) / 1000), why: "nothing is heard of vitrine serve" });
}, 5000);
