// Cases to choose from and sections that unfold; curves by plotly.js with the page's own legend,
// which a keyboard reaches and which wraps on a phone; and what printing needs: all cases and
// sections, plots and tables at the paper's width.
(() => {
  "use strict";
  const PAPER = 680;  // pixels across an A4 page inside its margins
  const touch = matchMedia("(pointer: coarse)").matches;
  const plots = [...document.querySelectorAll("figure.plot")];
  const area = (figure) => figure.querySelector(".area");
  const pressed = (button) => button.getAttribute("aria-pressed") === "true";

  function draw(figure) {
    if (area(figure).dataset.drawn) return;
    area(figure).dataset.drawn = "yes";
    const { data, layout, zoom } = JSON.parse(figure.querySelector("script").textContent);
    const buttons = ["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"];
    const options = {
      responsive: true,
      displaylogo: false,
      displayModeBar: touch ? true : "hover",
      modeBarButtons: [buttons],
      toImageButtonOptions: { filename: figure.id, scale: 2 },
    };
    if (touch) {  // a finger scrolls the page; the buttons zoom
      layout.dragmode = false;
      layout.margin.t = 36;
    }
    Plotly.newPlot(area(figure), data, layout, options);
    toggle(figure);
    if (zoom) ways(figure, zoom);
  }

  function toggle(figure) {
    const entries = [...figure.querySelectorAll(".legend button")];
    const traces = (entry) => JSON.parse(entry.dataset.traces);
    const show = (entry, on) => {
      entry.setAttribute("aria-pressed", on);
      return Plotly.restyle(area(figure), { visible: on }, traces(entry));
    };
    const isolate = (entry) => {  // that one alone, or all again
      const alone = entries.every((other) => pressed(other) === (other === entry));
      for (const other of entries) show(other, alone || other === entry);
    };
    for (const entry of entries) {
      entry.addEventListener("click", (event) =>
        event.shiftKey ? isolate(entry) : show(entry, !pressed(entry)));
      entry.addEventListener("dblclick", (event) => event.shiftKey || isolate(entry));
    }
  }

  // Buttons above a plot: its most wanted part or all of it, amplitudes logarithmic or linear.
  function ways(figure, [across, [low, high]]) {
    const [near, log] = figure.querySelectorAll(".ways button");
    const show = () => {
      const type = pressed(log) ? "log" : "linear";
      const up = pressed(log) ? [Math.log10(low), Math.log10(high)] : [0, high];
      Plotly.relayout(area(figure), { "yaxis.type": type, ...(pressed(near)
        ? { "xaxis.range": across, "yaxis.range": up }
        : { "xaxis.autorange": true, "yaxis.autorange": true }) });
    };
    for (const button of [near, log]) {
      button.addEventListener("click", () => {
        button.setAttribute("aria-pressed", !pressed(button));
        show();
      });
    }
  }

  // plotly.js is packed in the page; a script of its own text is within the page's policy.
  async function unpack() {
    const packed = document.getElementById("plotly");
    if (!packed) return;
    const bytes = Uint8Array.from(atob(packed.textContent), (letter) => letter.charCodeAt(0));
    const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
    const script = document.createElement("script");
    script.textContent = await new Response(stream).text();
    document.head.append(script);
  }

  // What can be seen is drawn, one after the other, so that the page can be read meanwhile.
  const unpacked = unpack();
  function reveal() {
    reach();
    return unpacked.then(() => {
      const seen = plots.filter((figure) => figure.checkVisibility());
      const next = seen.find((figure) => !area(figure).dataset.drawn);
      if (next) {
        draw(next);
        setTimeout(reveal, 0);
      }
    });
  }
  unpacked.catch(() => {
    for (const figure of plots) {
      area(figure).textContent = "Curves need a browser of 2023 or later; figures/ has pictures.";
    }
  });

  // The keyboard stops at tables that need scrolling, and at no others.
  function reach() {
    for (const box of document.querySelectorAll(".scroll")) {
      box.tabIndex = box.scrollWidth > box.clientWidth ? 0 : -1;
    }
  }
  window.addEventListener("resize", reach);

  const chooser = document.getElementById("case");
  const choose = () => {
    for (const block of document.querySelectorAll("[data-case]")) {
      block.hidden = chooser !== null && block.dataset.case !== chooser.value;
    }
    reveal();
  };
  chooser?.addEventListener("change", choose);
  choose();

  for (const whole of document.querySelectorAll("details")) {
    whole.addEventListener("toggle", reveal);
  }
  const unfold = () => {  // the section that an address names
    const target = location.hash.length > 1 && document.getElementById(location.hash.slice(1));
    const folded = target && target.querySelector(":scope > details.whole");
    if (folded && !folded.open) {
      folded.open = true;
      target.scrollIntoView();
    }
  };
  window.addEventListener("hashchange", unfold);
  for (const link of document.querySelectorAll("nav a")) {
    link.addEventListener("click", () => setTimeout(unfold, 0));
  }
  unfold();

  for (const frame of document.querySelectorAll(".picture .frame")) {
    frame.addEventListener("click", () => {  // between the column's width and the picture's own
      frame.setAttribute("aria-pressed", !pressed(frame));
    });
  }

  window.addEventListener("beforeprint", () => {
    document.documentElement.classList.add("printing");
    for (const folded of document.querySelectorAll("details:not([open])")) {
      folded.open = true;
      folded.dataset.opened = "";
    }
    for (const figure of plots) {
      if (window.Plotly) draw(figure);
      if (window.Plotly) Plotly.relayout(area(figure), { width: PAPER, height: 320 });
    }
    for (const table of document.querySelectorAll(".scroll table")) {
      const share = PAPER / table.scrollWidth;
      if (share < 1) table.style.fontSize = `${12 * share}px`;
    }
  });
  window.addEventListener("afterprint", () => {
    document.documentElement.classList.remove("printing");
    for (const opened of document.querySelectorAll("details[data-opened]")) {
      opened.open = false;
      delete opened.dataset.opened;
    }
    for (const figure of plots) {
      if (area(figure).dataset.drawn) {
        Plotly.relayout(area(figure), { width: null, height: null, autosize: true });
      }
    }
    for (const table of document.querySelectorAll(".scroll table")) table.style.fontSize = "";
  });
})();
