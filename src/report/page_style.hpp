#pragma once
/// @file The style sheet of the report.

namespace lumesh::report {

inline constexpr const char* kPageStyle = R"css(
:root {
  color-scheme: light dark;
  --page: #f6f5f2; --card: #ffffff; --ink: #1d2126; --soft: #646b75; --line: #e3e1db; --hair: #efede8;
  --accent: #a8443a; --bar: #c9665a; --bar-far: #7b3f9e; --good: #2c7a4b; --good-back: #e4f2e9; --bad: #b3261e; --bad-back: #fbe7e5;
}
@media (prefers-color-scheme: dark) {
  :root {
    --page: #14171a; --card: #1c2025; --ink: #e9e7e2; --soft: #9aa2ad; --line: #2d333a; --hair: #262b31;
    --accent: #e58f83; --bar: #d97f72; --bar-far: #b98be0; --good: #7fd3a0; --good-back: #1c3527; --bad: #ff9a90; --bad-back: #43211e;
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
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(150px, 1fr)); gap: 1px; background: var(--line); border: 1px solid var(--line); border-radius: 12px; overflow: hidden; margin-bottom: 22px; }
.tile { background: var(--card); padding: 15px 18px 13px; }
.tile b { display: block; font-size: 23px; line-height: 1.25; font-weight: 620; letter-spacing: -0.015em; font-variant-numeric: tabular-nums; white-space: nowrap; }
.tile span { color: var(--soft); font-size: 13px; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 12px; padding: 22px 24px; margin-bottom: 22px; break-inside: avoid; overflow-x: auto; }
.pair { display: grid; grid-template-columns: 1fr 1fr; gap: 22px; }
.pair > section { min-width: 0; }
figure { margin: 0; }
figure img { display: block; width: 100%; height: auto; max-height: 620px; object-fit: contain; }
figcaption { color: var(--soft); font-size: 13px; margin-top: 12px; }
.legend { display: flex; flex-wrap: wrap; gap: 6px 18px; margin: 14px 0 0; padding: 0; list-style: none; font-size: 13.5px; }
.legend i { display: inline-block; width: 12px; height: 12px; border-radius: 3px; margin-right: 7px; vertical-align: -1px; }
.scale { display: flex; align-items: center; gap: 10px; font-size: 13px; color: var(--soft); }
.scale .ramp { flex: 0 1 260px; height: 10px; border-radius: 5px; }
table { width: 100%; border-collapse: collapse; font-variant-numeric: tabular-nums; }
th, td { padding: 7px 12px 7px 0; text-align: right; border-top: 1px solid var(--hair); white-space: nowrap; }
th { font-weight: 550; color: var(--soft); font-size: 13px; border-top: 0; }
th:first-child, td:first-child { text-align: left; }
tr:last-child td { border-bottom: 0; }
th:last-child, td:last-child { padding-right: 0; }
td.text { text-align: left; white-space: normal; overflow-wrap: anywhere; }
td.key { color: var(--soft); width: 15em; vertical-align: top; }
td.worse { color: var(--bad); font-weight: 600; }
td.group { padding-top: 14px; font-weight: 600; }
.note { color: var(--soft); font-size: 13px; margin: 12px 0 0; }
svg { display: block; width: 100%; height: auto; }
svg text { fill: var(--soft); font-size: 12px; font-family: inherit; font-variant-numeric: tabular-nums; }
svg .bar { fill: var(--bar); } svg .bar.far { fill: var(--bar-far); } svg .axis { stroke: var(--line); }
footer { color: var(--soft); font-size: 13px; margin-top: 30px; }
@media (max-width: 820px) { .pair { grid-template-columns: 1fr; gap: 0; } main { padding: 28px 16px 48px; } }
@media print {
  :root { --page: #fff; --card: #fff; --ink: #000; --soft: #555; --line: #ccc; --hair: #e5e5e5; --accent: #a8443a; --bar: #c9665a; --bar-far: #7b3f9e; --good: #2c7a4b; --good-back: #fff; --bad: #b3261e; --bad-back: #fff; }
  main { max-width: none; padding: 0; } body { font-size: 12px; } section { padding: 14px 16px; margin-bottom: 12px; } figure img { max-height: 95mm; }
  @page { size: A4; margin: 14mm; }
}
)css";

}  // namespace lumesh::report
