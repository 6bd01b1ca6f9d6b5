// Follows the journal: replaces the parts of the page that changed. Without this file the page is whole, and stands still.
"use strict";

const body = document.body;
const state = document.getElementById("live");
const stop = document.createElement("button");
let stream = null;
let position = Number(body.dataset.position);

function say(text, how) {
  state.dataset.state = how;
  if (state.textContent !== text) state.textContent = text;
}

function ago() {
  for (const time of document.querySelectorAll("header time")) {
    const seconds = Math.max(0, Math.round((Date.now() - Date.parse(time.dateTime)) / 1000));
    time.title = time.title || time.textContent;
    const [number, unit] =
      seconds < 60 ? [seconds, "second"] : seconds < 3600 ? [seconds / 60, "minute"] : seconds < 86400 ? [seconds / 3600, "hour"] : [seconds / 86400, "day"];
    time.textContent = new Intl.RelativeTimeFormat("en", { numeric: "always" }).format(-Math.floor(number), unit);
  }
}

// The server made and escaped these parts as it made the page; what is focused, opened or scrolled stays so.
function replace(id, html) {
  const old = document.getElementById(id);
  if (!old) return;
  const known = new Set(Array.from(old.querySelectorAll("[id]"), (each) => each.id));
  const opened = Array.from(old.querySelectorAll("details[open] > summary[id]"), (each) => each.id);
  const scrolled = Array.from(old.querySelectorAll(".scroll"), (each) => each.scrollLeft);
  const focused = old.contains(document.activeElement) ? document.activeElement.id : "";
  old.innerHTML = html;
  for (const each of opened) document.getElementById(each)?.parentElement.setAttribute("open", "");
  old.querySelectorAll(".scroll").forEach((each, index) => (each.scrollLeft = scrolled[index] || 0));
  if (focused) document.getElementById(focused)?.focus({ preventScroll: true });
  if (known.size) for (const row of old.querySelectorAll("li[id]")) if (!known.has(row.id)) row.classList.add("fresh");
}

function follow() {
  const address = new URL(body.dataset.live, location.href);
  address.searchParams.set("after", String(position));
  stream = new EventSource(address);
  stream.onopen = () => say("live", "live");
  stream.onerror = () => {
    // A stream that was refused is not tried again by the browser itself.
    if (stream.readyState === EventSource.CLOSED) setTimeout(() => stream && follow(), 5000);
    say("not connected, trying again", "lost");
  };
  stream.addEventListener("parts", (message) => {
    const news = JSON.parse(message.data);
    position = news.position;
    for (const [id, html] of Object.entries(news.parts)) replace(id, html);
    say("live", "live");
    ago();
  });
  stream.addEventListener("trouble", (message) => say(JSON.parse(message.data).says, "lost"));
}

stop.type = "button";
stop.textContent = "Pause";
stop.addEventListener("click", () => {
  if (stream) {
    stream.close();
    stream = null;
    say("paused", "paused");
  } else {
    follow();
  }
  stop.textContent = stream ? "Pause" : "Go on";
});
state.parentElement.append(stop);
// The form leaves out of the address what was left empty, and a choice needs no further key.
const form = document.querySelector("form.filter");
form?.addEventListener("submit", () => {
  for (const field of form.elements) if (field.name && !field.value) field.disabled = true;
});
form?.addEventListener("change", (change) => {
  if (change.target.tagName === "SELECT") form.requestSubmit();
});
window.addEventListener("pageshow", () => {
  for (const field of form?.elements ?? []) field.disabled = false;
});
ago();
setInterval(ago, 5000);
follow();
