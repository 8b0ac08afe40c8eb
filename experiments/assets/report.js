// The replay of a drive: a slider moves the robot on the map and a mark over the errors.
"use strict";
for (const box of document.querySelectorAll(".replay")) {
  const drive = JSON.parse(box.querySelector("script[type='application/json']").textContent);
  const [left, low] = drive.low_m;
  const [width, height] = drive.size_m;
  const frames = drive.frames;
  const slider = box.querySelector("input");
  const said = box.querySelector("output");
  const make = (parent, name, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return parent.appendChild(element);
  };
  const line = (x, y) => x.map((value, k) => `${value.toFixed(3)},${y[k].toFixed(3)}`).join(" ");
  const style = (colour, wide) => `fill:none;stroke:${colour};stroke-width:${wide};stroke-linejoin:round`;

  const map = box.querySelector("svg.map");
  map.setAttribute("viewBox", `${left} ${low} ${width} ${height}`);
  const up = make(map, "g", { transform: `matrix(1 0 0 -1 0 ${2 * low + height})` });
  make(up, "rect", { x: left, y: low, width, height, style: "fill:none;stroke:var(--grid);stroke-width:.02" });
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  if (frames?.picture) {
    // The map image: the more comes from a cell, the less light passes.
    const { low_m: [x, y], size_m: [wide, high], columns, rows } = frames.picture;
    const picture = Object.assign(document.createElement("canvas"), { width: columns, height: rows });
    const pixels = new ImageData(columns, rows);
    bytes(frames.picture.cells).forEach((cell, k) => pixels.data.set([128, 128, 128, cell], 4 * k));
    picture.getContext("2d").putImageData(pixels, 0, 0);
    make(up, "image", {
      x, y, width: wide, height: high, preserveAspectRatio: "none", style: "image-rendering:pixelated",
      href: picture.toDataURL(),
    });
  }
  for (const wall of drive.walls) {
    const points = wall.points_m.map((point) => point.join(",")).join(" ");
    make(up, "polyline", { points, style: style("var(--ink)", Math.max(wall.thickness_m, 0.03)) });
  }
  // Landmarks as they are known, and poses that are possible.
  const known = make(up, "g", { style: style("var(--good)", 0.05) + ";stroke-linecap:round" });
  const possible = make(up, "g", { style: "fill:var(--ink);opacity:.5" });
  const robots = drive.tracks.map((track) => {
    make(up, "polyline", { points: line(track.x_m, track.y_m), style: style(track.colour, 0.015) + ";opacity:.6" });
    const group = make(up, "g", {});
    make(group, "circle", { r: 0.07, style: `fill:${track.colour};opacity:.85` });
    make(group, "line", { x1: 0, y1: 0, x2: 0.16, y2: 0, style: style(track.colour, 0.03) });
    return group;
  });

  const chart = box.querySelector("svg.errors");
  const end = drive.tracks[0].t_s.at(-1);
  const scored = drive.tracks.filter((track) => track.error_m.length > 0);
  let mark = null;
  if (chart) {
    const most = scored.reduce((high, track) => track.error_m.reduce((a, b) => Math.max(a, b), high), 1e-4);
    chart.setAttribute("viewBox", "0 0 100 24");
    chart.setAttribute("preserveAspectRatio", "none");
    for (const track of scored) {
      const points = line(track.t_s.map((t) => (100 * t) / end), track.error_m.map((e) => 23 - (22 * e) / most));
      make(chart, "polyline", { points, "vector-effect": "non-scaling-stroke", style: style(track.colour, 1.5) });
    }
    mark = make(chart, "line", {
      y1: 0, y2: 24, "vector-effect": "non-scaling-stroke", style: style("var(--ink)", 1),
    });
    box.querySelector(".most").textContent = `${most.toPrecision(2)} m`;
  }

  // The entry of rising times at a time: the last one that is not later, or the first.
  const entry = (times, t) => {
    let first = 0;
    let last = times.length - 1;
    while (first < last) {
      const middle = (first + last + 1) >> 1;
      if (times[middle] <= t + 1e-6) first = middle;
      else last = middle - 1;
    }
    return first;
  };

  // Echoes around the robot, turned as the map lies: a byte for each direction from the heading and each range.
  const canvas = box.querySelector("canvas");
  const echoes = frames ? bytes(frames.echoes) : null;
  const draw_echoes = (number, heading) => {
    const { directions, ranges } = frames;
    const [wide, half] = [canvas.width, canvas.width / 2];
    const context = canvas.getContext("2d");
    const pixels = context.createImageData(wide, wide);
    const first = number * directions * ranges;
    for (let y = 0; y < wide; y += 1) {
      for (let x = 0; x < wide; x += 1) {
        const [east, north] = [(x + 0.5 - half) / half, (half - y - 0.5) / half];
        const range = Math.floor(ranges * Math.hypot(east, north));
        if (range >= ranges) continue;
        const off = Math.acos(Math.cos(Math.atan2(north, east) - heading));
        const direction = Math.round(((directions - 1) * off) / Math.PI);
        pixels.data.set([0, 114, 178, echoes[first + direction * ranges + range]], 4 * (y * wide + x));
      }
    }
    context.putImageData(pixels, 0, 0);
    context.fillStyle = "#d55e00";
    context.translate(half, half);
    context.rotate(-heading);
    context.beginPath();
    context.moveTo(9, 0);
    context.lineTo(-6, 5);
    context.lineTo(-6, -5);
    context.fill();
    context.setTransform(1, 0, 0, 1, 0, 0);
  };
  let [landmarks, frame] = [-2, -1];
  const show_frame = (t, heading) => {
    const number = entry(frames.t_s, t);
    if (frames.t_s.length > 0 && number !== frame) {
      frame = number;
      draw_echoes(number, heading);
      possible.replaceChildren();
      for (const [x, y] of frames.poses[number]) make(possible, "circle", { cx: x, cy: y, r: 0.015 });
    }
    // Nothing is known before the first.
    const at = frames.landmarks.findLastIndex((set) => set.t_s <= t + 1e-6);
    if (at === landmarks) return;
    landmarks = at;
    known.replaceChildren();
    if (at < 0) return;
    for (const [[x1, y1], [x2, y2]] of frames.landmarks[at].walls) make(known, "line", { x1, y1, x2, y2 });
    for (const [x, y] of frames.landmarks[at].points) make(known, "circle", { cx: x, cy: y, r: 0.06 });
  };
  const show = () => {
    const t = (end * slider.value) / slider.max;
    const texts = [`${t.toFixed(1)} s`];
    drive.tracks.forEach((track, number) => {
      const k = entry(track.t_s, t);
      const turn = (180 * track.heading_rad[k]) / Math.PI;
      robots[number].setAttribute("transform", `translate(${track.x_m[k]} ${track.y_m[k]}) rotate(${turn})`);
      const words = [track.name];
      if (track.error_m.length > 0) words.push(`${track.error_m[k].toFixed(4)} m`);
      if (track.status) words.push(track.status[k]);
      if (frames && number === drive.watched) show_frame(t, track.heading_rad[k]);
      if (words.length > 1) texts.push(words.join(" "));
    });
    for (const side of mark ? ["x1", "x2"] : []) mark.setAttribute(side, (100 * t) / end);
    said.textContent = texts.join(" \u00b7 ");
  };
  slider.addEventListener("input", show);
  // A link may name the moment: report.html#t=12.5
  const moment = () => {
    const named = location.hash.match(/^#t=([0-9.]+)$/);
    if (named) slider.value = Math.round((slider.max * Number(named[1])) / end);
    show();
  };
  addEventListener("hashchange", moment);
  moment();
}
