// Runs before viser's own script: hands the token on to its socket, names for screen readers what has no name, and
// lets the keyboard reach what only the mouse could.
"use strict";
(() => {
  const given = new URLSearchParams(location.hash.slice(1)).get("token");
  if (given) {
    sessionStorage.setItem("token", given);
    history.replaceState(null, "", location.pathname);
  }
  const token = sessionStorage.getItem("token") || "";
  if (!/^[\w-]+$/.test(token)) {
    document.addEventListener("DOMContentLoaded", () => {
      document.body.textContent = "The token is missing: please open the address that was printed, with all that stands behind #.";
    });
    return;
  }

  // viser opens its socket in a worker, whose script it keeps in a blob.
  const socket = `{ const Plain = self.WebSocket; self.WebSocket = class extends Plain {
    constructor(url, protocols = []) { super(url, [].concat(protocols, "token.${token}")); } }; }\n`;
  const Plain = Blob;
  window.Blob = class extends Plain {
    constructor(parts = [], options = {}) {
      super(/javascript/.test(options.type) ? [socket, ...parts] : parts, options);
    }
  };

  const icons = { adjustments: "settings of this view" };
  const lacks = (each) => !each.getAttribute("aria-label") && !(each.labels && each.labels.length);

  function nameAll() {
    document.getElementById("root")?.setAttribute("role", "main");
    for (const label of document.querySelectorAll("label[for]")) {
      const beside = document.getElementById(label.htmlFor)?.parentElement;
      for (const each of beside?.querySelectorAll("[role=slider], input") ?? []) {
        if (lacks(each)) each.setAttribute("aria-label", label.textContent);
      }
    }
    for (const each of document.querySelectorAll("button")) {
      if (each.textContent.trim() || !lacks(each)) continue;
      const icon = /tabler-icon-([\w-]+)/.exec(each.innerHTML)?.[1] ?? "close";
      each.setAttribute("aria-label", icons[icon] ?? icon.replaceAll("-", " "));
    }
  }

  // Titles of folders are no buttons.
  const press = (event) => {
    if (event.key !== "Enter" && event.key !== " ") return;
    event.preventDefault();
    event.currentTarget.click();
  };

  function reachFolders() {
    for (const icon of document.querySelectorAll(".tabler-icon-chevron-down, .tabler-icon-chevron-up")) {
      const title = icon.parentElement;
      if (title.closest("button")) continue;
      if (!title.hasAttribute("role")) title.addEventListener("keydown", press);
      title.setAttribute("role", "button");
      title.setAttribute("tabindex", "0");
      title.setAttribute("aria-expanded", icon.classList.contains("tabler-icon-chevron-up"));
    }
  }

  let asked = false;
  const changed = () => {
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; nameAll(); reachFolders(); });
  };
  new MutationObserver(changed).observe(document, { childList: true, subtree: true });
})();
