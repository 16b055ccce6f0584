#include "src/job/report/report_style.h"

#include "src/base/phases.h"

namespace tessera {
namespace {

constexpr const char* style =
    R"(:root { color-scheme: light dark; --ink:#1d2430; --soft:#5d6878; --paper:#fbfbf9; --card:#ffffff; --line:#dfe3e8;
  --warning:#e08a2c; }
@media (prefers-color-scheme: dark) { :root { --ink:#e4e8ee; --soft:#98a3b3; --paper:#14181f; --card:#1c222b;
  --line:#323a46; --warning:#f0a04b; } }
* { box-sizing:border-box }
body { margin:0; background:var(--paper); color:var(--ink); font:15px/1.5 system-ui,sans-serif }
main { max-width:1060px; margin:0 auto; padding:32px 24px 64px }
h1 { font-size:26px; font-weight:650; margin:0 0 4px; letter-spacing:-.01em; overflow-wrap:anywhere }
h2 { font-size:17px; font-weight:650; margin:36px 0 10px }
p { margin:0 0 8px } .soft { color:var(--soft) } .number { white-space:nowrap }
code { font:13px/1.5 ui-monospace,monospace; overflow-wrap:anywhere }
.warning { border-left:3px solid var(--warning); padding-left:10px; overflow-wrap:anywhere }
.facts { display:grid; grid-template-columns:max-content 1fr; gap:3px 16px; margin:14px 0; font-size:14px }
.facts dt { color:var(--soft) } .facts dd { margin:0; overflow-wrap:anywhere; font-variant-numeric:tabular-nums }
.cards { display:grid; grid-template-columns:repeat(auto-fill,minmax(145px,1fr)); gap:10px; margin:20px 0 }
.card { background:var(--card); border:1px solid var(--line); border-radius:8px; padding:10px 14px }
.card b { display:block; font-size:20px; font-weight:600; font-variant-numeric:tabular-nums; white-space:nowrap }
.card span { color:var(--soft); font-size:13px }
.panel { background:var(--card); border:1px solid var(--line); border-radius:8px; padding:14px; overflow-x:auto }
.phases { display:flex; height:26px; border-radius:6px; overflow:hidden; margin-bottom:8px }
.phases div { min-width:1px }
.key { display:flex; flex-wrap:wrap; gap:4px 18px; font-size:13px; color:var(--soft); margin-bottom:10px }
.key i { display:inline-block; width:11px; height:11px; border-radius:3px; margin-right:6px }
.pictures { display:grid; grid-template-columns:repeat(auto-fill,minmax(min(100%,420px),1fr)); gap:16px }
.pictures figure { margin:0 }
figcaption { font-size:13px; color:var(--soft); margin-bottom:8px }
.scale { display:flex; align-items:center; gap:8px; margin-top:10px; font-size:13px; color:var(--soft) }
.scale i { flex:0 1 160px; height:9px; border-radius:2px }
svg { display:block; width:100%; height:auto }
svg.timeline { width:calc(100% - 72px); margin-left:72px; overflow:visible }
svg text { font:12px system-ui,sans-serif; fill:var(--soft) }
svg .tick { stroke:var(--line); stroke-width:1 }
svg.tiles rect { stroke:var(--card); stroke-width:1; vector-effect:non-scaling-stroke }
svg rect:hover { filter:brightness(1.15) }
table { border-collapse:collapse; width:100%; font-size:13.5px; font-variant-numeric:tabular-nums }
th,td { text-align:right; padding:4px 10px; border-bottom:1px solid var(--line); white-space:nowrap }
th { color:var(--soft); font-weight:500 } th:first-child,td:first-child { text-align:left }
@media (max-width:620px) { main { padding:20px 14px 40px } h1 { font-size:21px } .panel { padding:10px }
  .facts { grid-template-columns:1fr; gap:0 } .facts dd { margin-bottom:6px }
  svg.timeline .between { display:none } th,td { padding:4px 5px } table { font-size:13px } }
)";

}  // namespace

std::string report_style() {
  std::string light, dark, fills;
  for (const PhaseRow& row : phase_table) {
    if (row.colour == nullptr) continue;
    const std::string name = row.name;
    light += " --" + name + ":" + row.colour + ";";
    dark += " --" + name + ":" + row.dark_colour + ";";
    fills += ".p-" + name + " { fill:var(--" + name + "); background:var(--" + name + ") }\n";
  }
  return std::string("<style>\n:root {") + light + " }\n@media (prefers-color-scheme: dark) { :root {" + dark +
         " } }\n" + style + fills + "</style>\n";
}

}  // namespace tessera
