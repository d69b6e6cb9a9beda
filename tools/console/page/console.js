// The operator's page. Whatever comes from a run is put in as text; nothing of it is ever read as HTML.
"use strict";

const LOST_AFTER_MS = 5000;
const find = (name) => document.getElementById(name);
const tab = own("tab", () => crypto.randomUUID ? crypto.randomUUID() : String(Math.random()).slice(2));
const token = takeToken();
let state = { runs: [], lease: {} };
let chosen = decodeURIComponent(location.hash.slice(1));
let details = null;
let shown = "";
let heard = 0;

function own(key, make) {
  if (!sessionStorage.getItem(key)) sessionStorage.setItem(key, make());
  return sessionStorage.getItem(key);
}

function takeToken() {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  return sessionStorage.getItem("token") || "";
}

function element(kind, words, attributes = {}) {
  const made = document.createElement(kind);
  if (words !== undefined) made.textContent = words;
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  return made;
}

// Asking the server

function headers(more = {}) {
  return { Authorization: `Bearer ${token}`, "X-Console-Tab": tab, ...more };
}

async function get(path) {
  const answer = await fetch(path, { headers: headers() });
  const content = await answer.json();
  if (!answer.ok) throw new Error(content.error);
  return content;
}

async function post(path, content) {
  const answer = await fetch(path, {
    method: "POST",
    headers: headers({ "Content-Type": "application/json" }),
    body: JSON.stringify(content),
  });
  const reply = await answer.json();
  if (!answer.ok) throw new Error(reply.error);
  return reply;
}

const at = (name, rest) => `/api/runs/${encodeURIComponent(name)}${rest}`;

async function command(message) {
  const nonce = crypto.randomUUID ? crypto.randomUUID() : `${tab}-${performance.now()}`;
  await told(() => post(at(chosen, "/command"), { ...message, nonce }));
}

async function told(work) {
  try {
    find("said").textContent = "";
    return await work();
  } catch (error) {
    find("said").textContent = error.message;
    return null;
  }
}

// Hearing what goes on

async function listen() {
  for (;;) {
    try {
      const answer = await fetch("/api/events", { headers: headers() });
      if (answer.status === 401) {
        line("the token is missing or wrong: open the address that handcart console printed", true);
        return;
      }
      await hear(answer.body.getReader());
    } catch {
      // it is tried again
    }
    line("connection lost: runs go on without this page", true);
    enable();
    await new Promise((done) => setTimeout(done, 1000));
  }
}

async function hear(reader) {
  const decoder = new TextDecoder();
  let rest = "";
  for (;;) {
    const { value, done } = await reader.read();
    if (done) return;
    heard = Date.now();
    const lines = (rest + decoder.decode(value, { stream: true })).split("\n");
    rest = lines.pop();
    if (lines.length) update(JSON.parse(lines[lines.length - 1]));
  }
}

function update(now) {
  state = now;
  line("connected", false);
  drawRuns();
  if (!chosen && state.runs.length) choose(state.runs[0].name, false);
  drawRun();
}

function line(words, lost) {
  if (find("line").textContent !== words) find("line").textContent = words;
  find("line").classList.toggle("lost", lost);
  if (lost) heard = 0;
}

const connected = () => Date.now() - heard < LOST_AFTER_MS;
const commands = () => state.lease.tab === tab;
const current = () => state.runs.find((each) => each.name === chosen);

// The list

function drawRuns() {
  const list = find("runs");
  find("no-runs").hidden = state.runs.length > 0;
  const there = new Map([...list.children].map((each) => [each.dataset.name, each]));
  state.runs.forEach((run, number) => {
    let item = there.get(run.name);
    if (!item) {
      item = element("li", undefined, { "data-name": run.name });
      const button = element("button", undefined, { type: "button" });
      button.append(element("span", run.name), element("small"), element("span", "", { class: "badge" }));
      button.addEventListener("click", () => choose(run.name, true));
      item.append(button);
    }
    there.delete(run.name);
    item.className = run.alive ? (run.asks ? "asking" : "alive") : run.state.replace(/\W/g, "");
    const [, small, badge] = item.firstChild.children;
    small.textContent = `${run.backend}, seed ${run.seed}, ${new Date(run.begun * 1000).toLocaleString()}`;
    badge.textContent = run.asks ? "asks for permission" : run.state;
    item.firstChild.setAttribute("aria-current", String(run.name === chosen));
    if (list.children[number] !== item) list.insertBefore(item, list.children[number] || null);
  });
  there.forEach((item) => item.remove());
}

function choose(name, focus) {
  chosen = name;
  details = null;
  shown = "";
  find("said").textContent = "";
  drawRuns();
  drawRun();
  if (focus) find("run-title").scrollIntoView({ block: "nearest" });
}

// One run

function drawRun() {
  const run = current();
  find("run").hidden = !run;
  if (!run) return;
  find("run-title").textContent = run.name;
  const where = run.situation ? ` in ${run.situation} at ${run.sim_time_s.toFixed(1)} s` : "";
  const reason = !run.alive && details && details.reason ? `: ${details.reason}` : "";
  set("state", run.asks ? `waits for a permission${where}` : `${run.state}${where}${reason}`);
  drawCommands(run.commands || []);
  drawPlace(run);
  enable();
  const version = JSON.stringify([run.name, run.alive, run.state, run.situation, run.actions, run.asks && run.asks.ask, run.pages]);
  if (version !== shown) {
    shown = version;
    fetchDetails(run);
  }
}

function set(name, words) {
  if (find(name).textContent !== words) find(name).textContent = words;
}

async function fetchDetails(run) {
  const found = await told(() => get(at(run.name, "")));
  if (!found || run.name !== chosen) return;
  const changed = !details || JSON.stringify(details.network) !== JSON.stringify(found.network);
  details = found;
  if (changed) drawNetwork(found.network);
  drawAsks(run);
  drawActions(found.actions);
  drawWaits(run, found);
  drawPictures(run, found.pictures);
  drawView(found);
  drawPages(run, found.pages);
  drawRun();
}

function enable() {
  const run = current();
  const alive = Boolean(run && run.alive) && connected();
  find("stop").disabled = !alive;
  for (const each of document.querySelectorAll("#buttons button, #permit, #refuse")) each.disabled = !alive || !commands();
  for (const each of document.querySelectorAll(".acknowledge")) each.disabled = !connected() || !commands();
  const step = document.querySelector("[data-do=step]");
  step.setAttribute("aria-pressed", String(Boolean(run && run.step)));
  set("holder", commands() ? "you command" : state.lease.name ? `${state.lease.name} commands` : "nobody commands");
  find("take").textContent = commands() ? "Give it back" : "Take the command";
}

function drawAsks(run) {
  const asks = run.asks;
  find("asks").hidden = !asks;
  if (!asks) return;
  const action = `${asks.do} from ${asks.from} to ${asks.to}`;
  find("asks-what").textContent = action;
  const list = find("asks-with");
  list.replaceChildren();
  for (const [name, value] of Object.entries(asks.with || {})) list.append(element("dt", name), element("dd", String(value)));
  find("asks-after").textContent = "";
  told(() => get(at(run.name, `/after/${asks.index}`))).then((after) => {
    if (after) find("asks-after").textContent = outlook(after);
  });
  const newest = details.pictures[details.pictures.length - 1];
  find("asks-picture").hidden = !newest;
  if (newest) picture(find("asks-picture"), run.name, newest, "What the robot saw last");
}

function outlook(after) {
  if (after.unknown) return `P(goal) isn't known: ${after.unknown}.`;
  const share = (p) => `${(100 * p).toFixed(1)} %`;
  return `P(goal): permitted ${share(after.permitted)}, once it has succeeded ${share(after.succeeded)}, ` +
    `refused (it counts as failed) ${share(after.refused)}.`;
}

let reasons = { run: "", number: 0, lines: [] };

function askWhy(number) {
  const run = chosen;
  if (reasons.run === run && reasons.number === number) {
    reasons = { run: "", number: 0, lines: [] };
    drawActions(details.actions);
    return;
  }
  told(() => get(at(run, `/why/${number}`))).then((found) => {
    if (!found || chosen !== run) return;
    reasons = { run, number, lines: found.why || [`It isn't known why: ${found.unknown}.`] };
    drawActions(details.actions);
  });
}

function whyCell(each) {
  const cell = element("td");
  const open = reasons.run === chosen && reasons.number === each.number;
  const button = element("button", each.do, { type: "button", title: "Why this action?", "aria-expanded": String(open) });
  button.addEventListener("click", () => askWhy(each.number));
  cell.append(button);
  if (open) {
    const list = element("ul");
    list.append(...reasons.lines.map((line) => element("li", line)));
    cell.append(list);
  }
  return cell;
}

function drawActions(actions) {
  const rows = actions.slice().reverse().map((each) => {
    const row = element("tr");
    const took = each.outcome ? (each.end - each.start).toFixed(1) : "";
    row.append(element("td", each.number, { class: "number" }), whyCell(each),
      element("td", `${each.from}, ${each.to}`), element("td", took, { class: "number" }),
      element("td", each.outcome || "goes on"), element("td", each.reason));
    return row;
  });
  find("actions").replaceChildren(...rows);
}

function drawCommands(said) {
  const words = said.map((each) => {
    const more = each.at ? ` ${each.at}` : each.ask ? ` question ${each.ask}` : "";
    const off = each.on === false ? " off" : "";
    return `${each.sim_time_s.toFixed(1)} s: ${each.do}${more}${off}, by ${each.by}`;
  });
  const list = find("commands");
  if (JSON.stringify(words) === list.dataset.words) return;
  list.dataset.words = JSON.stringify(words);
  list.replaceChildren(...words.reverse().map((each) => element("li", each)));
}

function drawWaits(run, found) {
  const cards = found.waits.map((each) => {
    const card = element("div", undefined, { class: "waits" });
    card.append(element("h3", "Waits for a person"), element("p", each.reason),
      element("p", `record ${each.record}, cause ${each.cause.slice(0, 12)}`));
    for (const seen of found.pictures.filter((one) => one.action === each.action)) {
      const image = element("img");
      picture(image, run.name, seen, `Action ${seen.action}`);
      card.append(image);
    }
    const button = element("button", "Acknowledge …", { class: "acknowledge", type: "button" });
    button.addEventListener("click", () => sure(
      "Acknowledge", "All is as it was before this, and the run may go on:", `record ${each.record}: ${each.reason}`,
      () => post(at(run.name, "/acknowledge"), { record: each.record, cause: each.cause })));
    card.append(button);
    return card;
  });
  for (const each of found.moved) {
    if (each.reason) {
      cards.push(element("p", `Between two actions (record ${each.record}): ${each.reason}`));
      continue;
    }
    const sized = ([name, size]) => `${name} ${size === null ? "unknown" : Number(size).toPrecision(3)}`;
    const off = Object.entries(each.residuals).map(sized).join(", ");
    const unknown = each.unknown.length ? `; unknown: ${each.unknown.join(", ")}` : "";
    cards.push(element("p", `When it was gone on with (record ${each.record}), the robot stood beside where it was left: ` +
      `${off || "nothing known"}${unknown}`));
  }
  if (!run.alive && run.state === "broken off") cards.push(element("p", `It broke off; to go on: ${found.resume}`));
  find("waits").replaceChildren(...cards);
  enable();
}

function drawPictures(run, pictures) {
  find("pictures-part").hidden = !pictures.length;
  const there = new Set([...find("pictures").children].map((each) => each.dataset.file));
  const key = (each) => `${run.name}/${each.file}`;
  const wanted = pictures.slice(-12);
  if (wanted.every((each) => there.has(key(each))) && there.size === wanted.length) return;
  find("pictures").replaceChildren(...wanted.reverse().map((each) => {
    const figure = element("figure", undefined, { "data-file": key(each) });
    const image = element("img");
    const words = each.file.replace(/^.*\//, "").replace(/\.\w+$/, "");
    picture(image, run.name, each, words);
    figure.append(image, element("figcaption", words));
    return figure;
  }));
}

async function picture(image, name, each, words) {
  const path = each.file.split("/").map(encodeURIComponent).join("/");
  const answer = await fetch(at(name, `/files/${path}`), { headers: headers() });
  if (!answer.ok) return;
  if (image.src) URL.revokeObjectURL(image.src);
  image.alt = words;
  image.src = URL.createObjectURL(await answer.blob());
}

function drawView(found) {
  const said = element("p");
  if (found.view) {
    said.append(element("a", "Live view in three dimensions", { href: found.view, target: "_blank", rel: "noopener" }));
  } else if (current().alive) {
    said.textContent = "A run that is begun with --view can be watched in three dimensions while it goes on.";
  } else {
    said.append("In three dimensions: ", element("code", found.view_command));
  }
  find("view").replaceChildren(said);
}

function drawPages(run, pages) {
  find("pages").replaceChildren(...pages.map((page) => {
    const button = element("button", `Open ${page}`, { type: "button" });
    button.addEventListener("click", () => told(async () => {
      const { url } = await post(at(run.name, "/ticket"), { page });
      window.open(url, "_blank", "noopener");
    }));
    return button;
  }));
}

// The network

function drawNetwork(network) {
  find("network").replaceChildren();
  if (!network) return;
  const read = new DOMParser().parseFromString(network.svg, "image/svg+xml").documentElement;
  read.setAttribute("role", "group");
  const svg = document.importNode(read, true);
  for (const box of network.situations) {
    const spot = document.createElementNS("http://www.w3.org/2000/svg", "rect");
    for (const name of ["x", "y", "width", "height"]) spot.setAttribute(name, box[name]);
    spot.setAttribute("rx", "12");
    spot.setAttribute("class", "spot");
    spot.setAttribute("role", "button");
    spot.setAttribute("tabindex", "0");
    spot.setAttribute("aria-label", `Break point at ${box.name}`);
    spot.addEventListener("click", () => pressed(box));
    spot.addEventListener("keydown", (event) => {
      if (event.key !== "Enter" && event.key !== " ") return;
      event.preventDefault();
      pressed(box);
    });
    svg.append(spot);
  }
  find("network").append(svg);
}

function pressed(box) {
  const run = current();
  if (!run || !run.alive || !commands()) {
    find("said").textContent = run && run.alive ? "take the command first" : "the run is over";
    return;
  }
  const on = !box.situations.every((each) => run.breaks.includes(each));
  command({ do: "break", places: box.situations, on });
}

function drawPlace(run) {
  if (!details || !details.network) return;
  const here = run.situation || details.situation;
  document.querySelectorAll("#network .spot").forEach((spot, number) => {
    const box = details.network.situations[number];
    const isHere = box.situations.includes(here);
    if (isHere && !spot.classList.contains("here")) spot.scrollIntoView({ block: "nearest", inline: "center" });
    spot.classList.toggle("here", isHere);
    spot.setAttribute("aria-pressed", String(box.situations.every((each) => (run.breaks || []).includes(each))));
  });
}

// Buttons

function sure(title, what, quote, work) {
  find("sure-title").textContent = title;
  find("sure-what").textContent = what;
  find("sure-quote").textContent = quote;
  find("sure-yes").textContent = title;
  find("sure-yes").onclick = async () => {
    find("sure").close();
    await told(work);
    shown = "";
    drawRun();
  };
  find("sure").showModal();
}

find("sure-no").addEventListener("click", () => find("sure").close());
find("stop").addEventListener("click", () => told(() => post(at(chosen, "/stop"), {})));
find("permit").addEventListener("click", () => answer("permit"));
find("refuse").addEventListener("click", () => answer("refuse"));
for (const button of document.querySelectorAll("#buttons button")) {
  button.addEventListener("click", () => {
    const word = button.dataset.do;
    if (word === "step") command({ do: word, on: !(current() || {}).step });
    else if (word === "cancel") {
      const acting = (current() || {}).acting;  // the action that was shown when it was pressed
      const meant = typeof acting === "number" ? { number: acting } : {};
      sure("Cancel", "The robot moves: it brings back what the action did, then the run ends.",
        chosen, () => post(at(chosen, "/command"), { do: word, ...meant }));
    }
    else command({ do: word });
  });
}
find("command").addEventListener("submit", (event) => {
  event.preventDefault();
  const name = find("name").value.trim() || "operator";
  sessionStorage.setItem("name", name);
  told(() => post("/api/lease", commands() ? { take: false } : { take: true, name }));
});
find("name").value = sessionStorage.getItem("name") || "";

function answer(word) {
  const run = current();
  if (run && run.asks) command({ do: word, action: run.asks.index, ask: run.asks.ask });
}

setInterval(() => { if (heard && !connected()) line("connection lost: runs go on without this page", true), enable(); }, 1000);
if (token) listen();
else line("the token is missing: open the address that handcart console printed", true);
