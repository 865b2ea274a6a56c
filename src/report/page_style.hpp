#pragma once
/// @file The style sheet of the report.

namespace lumesh::report {

inline constexpr const char* kPageStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #f6f5f2; --card: #ffffff; --ink: #1d2126; --soft: #646b75; --line: #e3e1db; --hair: #efede8;
  --accent: #a8443a; --bar: #c9665a; --bar-far: #7b3f9e; --series-1: #4d7fb5; --series-2: #c9503f; --series-3: #3f8f5f; --series-4: #8a63b8; --good: #2c7a4b; --good-back: #e4f2e9; --bad: #b3261e; --bad-back: #fbe7e5;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14171a; --card: #1c2025; --ink: #e9e7e2; --soft: #9aa2ad; --line: #2d333a; --hair: #262b31;
    --accent: #e58f83; --bar: #d97f72; --bar-far: #b98be0; --series-1: #7fb0e6; --series-2: #f08a7a; --series-3: #7fd3a0; --series-4: #c3a1ee; --good: #7fd3a0; --good-back: #1c3527; --bad: #ff9a90; --bad-back: #43211e;
  }
}
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); font: 15px/1.5 system-ui, "Segoe UI", "Helvetica Neue", "DejaVu Sans", sans-serif; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
main { max-width: 1120px; margin: 0 auto; padding: 44px 28px 64px; }
header { display: flex; flex-wrap: wrap; align-items: baseline; gap: 4px 16px; margin-bottom: 26px; }
h1 { font-size: 29px; line-height: 1.2; font-weight: 640; letter-spacing: -0.015em; margin: 0; overflow-wrap: anywhere; }
header p { flex-basis: 100%; margin: 0; color: var(--soft); }
h2 { font-size: 12.5px; font-weight: 650; letter-spacing: 0.07em; text-transform: uppercase; color: var(--soft); margin: 0 0 14px; }
.badge { font-size: 13px; font-weight: 600; padding: 3px 12px; border-radius: 99px; color: var(--good); background: var(--good-back); }
.badge.bad { color: var(--bad); background: var(--bad-back); }
.badge.plain { color: var(--soft); background: var(--hair); }
.tiles { display: flex; flex-wrap: wrap; gap: 1px; background: var(--line); border: 1px solid var(--line); border-radius: 12px; overflow: hidden; margin-bottom: 22px; }
.tile { flex: 1 1 138px; background: var(--card); padding: 15px 18px 13px; }
.tile b { display: block; font-size: 23px; line-height: 1.25; font-weight: 620; letter-spacing: -0.015em; font-variant-numeric: tabular-nums; white-space: nowrap; }
.tile span { color: var(--soft); font-size: 13px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 12px; padding: 22px 24px; margin-bottom: 22px; break-inside: avoid; overflow-x: auto; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 22px; }
.pair > * { min-width: 0; }
figure { margin: 0; }
figure img { display: block; width: 100%; height: auto; max-height: 620px; object-fit: contain; }
figcaption { color: var(--soft); font-size: 13px; margin: 12px 0 8px; }
.legend { display: flex; flex-wrap: wrap; gap: 6px 18px; margin: 14px 0 0; padding: 0; list-style: none; font-size: 13.5px; }
.legend i { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin-right: 7px; vertical-align: -1px; }
.scale { display: flex; flex-wrap: wrap; align-items: center; gap: 2px 10px; font-size: 13px; color: var(--soft); }
.scale span { white-space: nowrap; } .scale .ramp { flex: 1 1 80px; max-width: 260px; height: 10px; border-radius: 5px; }
table { width: 100%; border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 7px 12px 7px 0; text-align: right; border-top: 1px solid var(--hair); white-space: nowrap; }
th { font-weight: 550; color: var(--soft); font-size: 13px; border-top: 0; }
th:first-child, td:first-child { text-align: left; }
tr:last-child td { border-bottom: 0; }
th:last-child, td:last-child { padding-right: 0; }
td.text { text-align: left; white-space: normal; overflow-wrap: anywhere; }
.numbers td { white-space: normal; } .numbers td.value { white-space: nowrap; } .numbers td.words { overflow-wrap: anywhere; }
td.key { color: var(--soft); width: 15em; vertical-align: top; }
td.worse { color: var(--bad); font-weight: 600; }
td.group { padding-top: 14px; font-weight: 600; }
.note { color: var(--soft); font-size: 13px; margin: 12px 0 0; }
.picture { position: relative; } figure .names { position: absolute; inset: 0; height: 100%; pointer-events: none; }
.names text { font: 600 var(--letter) ui-monospace, "DejaVu Sans Mono", monospace; text-anchor: middle; fill: var(--ink); stroke: var(--card); stroke-width: calc(0.25 * var(--letter)); stroke-linejoin: round; paint-order: stroke; }
.names path { fill: none; stroke: var(--ink); stroke-width: calc(0.085 * var(--letter)); stroke-linecap: round; } .names .halo path { stroke: var(--card); stroke-width: calc(0.28 * var(--letter)); }
.names .hidden { stroke-dasharray: calc(0.25 * var(--letter)); }
svg { display: block; width: 100%; height: auto; }
svg text { fill: var(--soft); font-size: 12px; font-family: inherit; font-variant-numeric: tabular-nums; }
svg .bar { fill: var(--bar); } svg .bar.far { fill: var(--bar-far); } svg .axis { stroke: var(--line); }
svg .series { fill-opacity: 0.1; stroke-width: 1.6; stroke-linejoin: round; }
h2.stage { font-size: 21px; font-weight: 640; letter-spacing: -0.01em; text-transform: none; color: var(--ink); margin: 46px 0 6px; break-after: avoid; }
h2.stage b { color: var(--accent); margin-right: 6px; } h2.stage span { font-size: 15px; font-weight: 400; color: var(--soft); margin-left: 8px; }
.lead { color: var(--soft); margin: 0 0 18px; max-width: 46em; break-after: avoid; }
.flow td { vertical-align: top; } .flow p { color: var(--soft); font-size: 13.5px; margin: 1px 0 0; } .flow .number { color: var(--accent); font-weight: 640; width: 1.6em; }
.flow .share { width: 22%; vertical-align: middle; } .flow .share i { display: block; height: 10px; min-width: 2px; border-radius: 3px; background: var(--bar); }
.findings td { vertical-align: top; } .findings th.text { text-align: left; } .findings .places, .findings code { white-space: nowrap; } ol.places { margin: 0; padding-left: 1.8em; columns: 330px; font-variant-numeric: tabular-nums; } ol.places li { break-inside: avoid; }
a { color: inherit; text-decoration-color: var(--accent); text-underline-offset: 3px; }
.aside { color: var(--soft); font-size: 13px; }
dl { display: grid; grid-template-columns: max-content 1fr; gap: 9px 22px; margin: 0; } dt { font-weight: 600; max-width: 14em; } dd { margin: 0; }
pre { margin: 0; font: 12.5px/1.5 ui-monospace, "DejaVu Sans Mono", monospace; white-space: pre-wrap; overflow-wrap: anywhere; } code { font: 13px ui-monospace, "DejaVu Sans Mono", monospace; overflow-wrap: anywhere; white-space: normal; }
.warnings { border-left: 4px solid var(--accent); } .warnings p { margin: 0 0 6px; overflow-wrap: anywhere; }
.plot figcaption { margin: 0 0 4px; }
section > .plot { margin-bottom: 18px; }
footer { color: var(--soft); font-size: 13px; margin-top: 30px; }
@media (max-width: 820px) { .pair { grid-template-columns: 1fr; gap: 0; } .flow .share { display: none; } dl { grid-template-columns: 1fr; gap: 2px; } dd { margin-bottom: 9px; } main { padding: 28px 16px 48px; } }
@media print {
  :root { --page: #fff; --card: #fff; --ink: #000; --soft: #555; --line: #ccc; --hair: #e5e5e5; --accent: #a8443a; --bar: #c9665a; --bar-far: #7b3f9e; --series-1: #4d7fb5; --series-2: #c9503f; --series-3: #3f8f5f; --series-4: #8a63b8; --good: #2c7a4b; --good-back: #fff; --bad: #b3261e; --bad-back: #fff; }
  main { max-width: none; padding: 0; } body { font-size: 12px; } section { padding: 14px 16px; margin-bottom: 12px; } .pair { grid-template-columns: 1fr 1fr; gap: 12px; } .flow .share { display: table-cell; } h2.stage { margin-top: 26px; } figure img { max-height: 95mm; }
  @page { size: A4; margin: 14mm; }
}
)css";

}  // namespace lumesh::report
