"use strict";
// One viewer over the figures that the page already shows: without it nothing is lost but comfort.
const sets = [...document.querySelectorAll(".set[data-name]")].map(e => {
  const images = {};
  e.querySelectorAll("img[data-role]").forEach(i => images[i.dataset.role] = i);
  const names = { reference: e.dataset.reference, test: e.dataset.test, flip: "FLIP", signed: "signed error" };
  return { name: e.dataset.name, images, names };
});
const viewer = document.querySelector(".viewer");
const $ = s => viewer.querySelector(s);
const [stage, panes, cut, read] = [".stage", ".panes", ".cut", ".read"].map($);
let [set, mode, zoom, at] = [0, "slider", "fit", 0.5];

const pixels = new WeakMap();
function colour(img, x, y) {
  if (!img) return null;
  if (!pixels.has(img)) {
    const c = document.createElement("canvas");
    [c.width, c.height] = [img.naturalWidth, img.naturalHeight];
    const g = c.getContext("2d", { willReadFrequently: true });
    g.drawImage(img, 0, 0);
    pixels.set(img, g);
  }
  return pixels.get(img).getImageData(x, y, 1, 1).data;
}

function width(img, count) {
  if (zoom !== "fit") return img.naturalWidth * zoom;
  const free = (stage.clientWidth - 4 * (count - 1)) / count;
  return Math.max(64, Math.min(free, 0.8 * innerHeight * img.naturalWidth / img.naturalHeight));
}

function pane(roles, count) {
  const p = document.createElement("div");
  p.className = "pane";
  roles.forEach((role, i) => {
    const source = sets[set].images[role], img = new Image(), w = width(source, count);
    [img.src, img.alt, img.draggable] = [source.src, sets[set].names[role], false];
    img.style.width = w + "px";
    if (w > 1.5 * source.naturalWidth) p.classList.add("big");
    const tag = document.createElement("span");
    tag.className = "tag";
    tag.textContent = sets[set].names[role];
    tag.style[roles.length > 1 && i === 0 ? "right" : "left"] = ".3rem";
    if (i > 0) img.className = "top";
    p.append(img, tag);
  });
  if (roles.length > 1) {
    const line = document.createElement("div");
    line.className = "line";
    p.append(line);
  }
  return p;
}

function divide() {
  const top = $(".top"), line = $(".line");
  if (!top) return;
  top.style.clipPath = `inset(0 ${100 - 100 * at}% 0 0)`;
  line.style.left = 100 * at + "%";
  cut.value = 1000 * at;
}

function draw() {
  // The right of the divide is the reference, the left the picture that is judged.
  const shown = mode === "slider" ? [["reference", "test"]] : mode === "both" ? [["test"], ["reference"]] : [[mode]];
  panes.replaceChildren(...shown.map(r => pane(r, shown.length)));
  cut.hidden = mode !== "slider";
  divide();
}

function choose(m) {
  const radio = $(`input[value=${m}]`);
  if (!radio || radio.parentElement.hidden) return;
  radio.checked = true;
  mode = m;
  draw();
}

function start() {
  viewer.hidden = false;
  const list = $("select[name=set]");
  sets.forEach((s, i) => list.add(new Option(s.name, i)));
  list.parentElement.hidden = sets.length < 2;
  const has = () => viewer.querySelectorAll("input[name=mode]").forEach(r => {
    const name = sets[set].names[r.value];
    if (!name) return;
    r.nextElementSibling.textContent = name;
    r.parentElement.hidden = !sets[set].images[r.value];
  });
  const open = n => {
    list.value = set = n;
    has();
    choose(mode in sets[set].names && !sets[set].images[mode] ? "slider" : mode);
  };
  list.onchange = () => open(+list.value);
  $("select[name=zoom]").onchange = e => { zoom = e.target.value === "fit" ? "fit" : +e.target.value; draw(); };
  viewer.querySelectorAll("input[name=mode]").forEach(r => r.onchange = () => choose(r.value));
  cut.oninput = () => { at = cut.value / 1000; divide(); };
  document.querySelectorAll("[data-open]").forEach(b => {
    b.hidden = false;
    b.onclick = () => {
      open(sets.findIndex(s => s.name === b.dataset.open));
      viewer.scrollIntoView({ behavior: "smooth" });
    };
  });
  let held = false;
  const place = e => {
    const p = e.target.closest(".pane");
    if (!p) return null;
    const box = p.getBoundingClientRect();
    return [(e.clientX - box.left) / box.width, (e.clientY - box.top) / box.height];
  };
  stage.onpointerdown = e => { held = mode === "slider" && e.button === 0 && !!place(e); if (held) slide(e); };
  onpointerup = () => held = false;
  const slide = e => { const p = place(e); if (p) { at = Math.max(0, Math.min(1, p[0])); divide(); } };
  stage.onpointermove = e => {
    if (held) slide(e);
    const p = place(e), i = sets[set].images;
    if (!p) return;
    const [w, h] = [i.reference.naturalWidth, i.reference.naturalHeight];
    const x = Math.min(w - 1, Math.max(0, Math.floor(p[0] * w))), y = Math.min(h - 1, Math.max(0, Math.floor(p[1] * h)));
    const rgb = role => [...colour(i[role], x, y).slice(0, 3)].map(v => String(v).padStart(3)).join(" ");
    const f = colour(i.values, x, y);
    const { reference, test } = sets[set].names;
    read.textContent = `${x}, ${y}   ${test} ${rgb("test")}   ${reference} ${rgb("reference")}` +
      (f ? `   FLIP ${((f[0] / 255) ** 2).toFixed(3)}` : "");
  };
  stage.onkeydown = e => {
    if (e.key === "f" || e.key === " ") { choose(mode === "reference" ? "test" : "reference"); e.preventDefault(); }
    else if (mode === "slider" && (e.key === "ArrowLeft" || e.key === "ArrowRight")) {
      at = Math.max(0, Math.min(1, at + (e.key === "ArrowLeft" ? -0.01 : 0.01))); divide(); e.preventDefault();
    }
  };
  onresize = draw;
  has();
  draw();
}
if (sets.length) Promise.all([...document.images].map(i => i.decode().catch(() => 0))).then(start);
