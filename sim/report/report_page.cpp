#include "sim/report/report_page.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/basics/text.h"
#include "sim/viewer/packed_view.h"
#include "sim/viewer/viewer_files.h"

namespace tiltfeed::sim {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light dark;--ground:#f3f4f6;--sheet:#fff;--line:#d9dde2;--text:#1c232b;--soft:#55606c;--accent:#0b5cad;--on-accent:#fff;--bad:#b3261e;--bad-ground:#fdeced;--warn:#7a4d00;--warn-ground:#fff3dc;--good:#1b6e3a;--head:#e9ecef}
@media(prefers-color-scheme:dark){:root{--ground:#10161d;--sheet:#18212b;--line:#3a4857;--text:#e6edf3;--soft:#a3b1c0;--accent:#6db3ff;--on-accent:#06121f;--bad:#ff9c94;--bad-ground:#391816;--warn:#ffcf7d;--warn-ground:#33270f;--good:#7ddc9f;--head:#22303d}}
*{box-sizing:border-box}[hidden]{display:none!important}body{margin:0;background:var(--ground);color:var(--text);font:15px/1.5 system-ui,'DejaVu Sans',sans-serif}
main{max-width:1320px;margin:0 auto;padding:24px}h1{font-size:26px;margin:0;overflow-wrap:anywhere}h2{font-size:18px;margin:34px 0 10px}
.verdict{display:inline-block;padding:3px 14px;border-radius:4px;color:#fff;font-weight:700;letter-spacing:.06em;margin-left:14px;vertical-align:3px;font-size:16px}
.good{background:#1d7a3e}.bad{background:#b3132b}.part{background:#8f5600}.sub{color:var(--soft);margin:4px 0 0;overflow-wrap:anywhere}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(150px,1fr));gap:10px;margin-top:18px}
.card{background:var(--sheet);border:1px solid var(--line);border-radius:6px;padding:10px 14px}.card b{display:block;font-size:21px;font-variant-numeric:tabular-nums}.card span{color:var(--soft);font-size:13px}
.wide{overflow-x:auto}table{border-collapse:collapse;width:100%;background:var(--sheet);border:1px solid var(--line);font-variant-numeric:tabular-nums}
th,td{padding:6px 10px;text-align:left;border-bottom:1px solid var(--line)}th{background:var(--head);font-size:13px}td.n,th.n{text-align:right}a{color:var(--accent)}
main>img,main>svg,figure img,figure svg{width:100%;height:auto;display:block;background:var(--sheet);border:1px solid var(--line);border-radius:6px}
figure{margin:0}figcaption{color:var(--soft);font-size:13px;margin-top:6px}ul.bad-list{background:var(--bad-ground);border:1px solid var(--bad);border-radius:6px;padding:10px 14px 10px 34px}
pre{background:#20262d;color:#dfe5ea;padding:10px 14px;border-radius:6px;overflow:auto;font-size:13px;line-height:1.45}pre mark{background:#8c1126;color:#fff}
details{margin:8px 0}summary{cursor:pointer}
button,input,select{font:inherit;color:inherit}button{min-height:40px;padding:.4rem .9rem;border:1px solid var(--line);border-radius:6px;background:var(--sheet);cursor:pointer}select{min-height:40px;padding:.3rem .5rem;border:1px solid var(--soft);border-radius:6px;background:var(--sheet);max-width:100%}
:focus-visible{outline:3px solid var(--accent);outline-offset:2px}
.plot{fill:var(--sheet);stroke:var(--line)}.rate{fill:#2e6fb2}.cutting{fill:#2f8a57;background:#2f8a57}.air{fill:#d9a520;background:#d9a520}.rapid{fill:#8aa0b4;background:#8aa0b4}.place{fill:#2e6fb2;stroke:#2e6fb2;stroke-width:.8}.speed{fill:#76879a}
.limit{stroke:#b3132b;stroke-width:1.2;stroke-dasharray:6 4}.trouble{stroke:#b3132b;stroke-width:1.6}
svg text{font:12px system-ui,'DejaVu Sans',sans-serif;fill:var(--text)}svg .name{font-weight:700}svg .unit,svg .tick,svg .hour{fill:var(--soft);font-size:11px}svg .tick{text-anchor:end}svg .hour{text-anchor:middle}
.key{display:inline-block;width:12px;height:12px;border-radius:2px;margin:0 5px 0 14px;vertical-align:-1px}
#report-viewer{margin-top:18px;border:1px solid var(--line);border-radius:6px;overflow:hidden;background:var(--sheet)}
)";

std::string figure(const std::string& png, const std::string& what, const std::string& caption) {
  return "<figure><img alt='" + escaped(what) + "' src='data:image/png;base64," + base64(png) +
         "'>\n<figcaption>" + caption + "</figcaption></figure>\n";
}

std::string card(const std::string& value, const std::string& what) {
  return "<div class='card'><b>" + value + "</b><span>" + what + "</span></div>\n";
}

std::string legend(const std::vector<ColourStop>& scale) {
  std::string stops, labels;
  const double step = 860.0 / static_cast<double>(scale.size() - 1);
  for (std::size_t i = 0; i < scale.size(); ++i) {
    const double at = static_cast<double>(i) / static_cast<double>(scale.size() - 1);
    stops += text("<stop offset='%.4f' stop-color='%s'/>", at, html_colour(scale[i].colour).c_str());
    labels += text("<text x='%.1f' y='44' text-anchor='middle'>%.3g</text>",
                   40.0 + step * static_cast<double>(i), scale[i].left);
  }
  return "<svg viewBox='0 0 1040 66'><defs><linearGradient id='scale'>" + stops +
         "</linearGradient></defs><rect x='40' y='10' width='860' height='18' fill='url(#scale)'/>" + labels +
         "<text x='40' y='60' text-anchor='start'>cut into the part</text>"
         "<text x='900' y='60' text-anchor='end'>material left, mm</text>" +
         "<rect x='940' y='10' width='18' height='18' fill='" + html_colour(kUnreachedColour) +
         "'/><text x='964' y='24'>never cut</text></svg>\n";
}

std::string head(const PageParts& p) {
  const config::Job& job = p.context.job;
  const bool good = p.verdict.passed();
  std::string html =
      "<h1>" + escaped(job.plan.name) + "<span class='verdict " +
      (good                     ? "good'>PASSED"
       : p.verdict.incomplete() ? "part'>INCOMPLETE"
                                : "bad'>FAILED") +
      "</span></h1>\n<p class='sub'>" + escaped(p.context.source) + " on machine " +
      escaped(job.machine.model.name) + ", stock " +
      escaped(to_string(p.context.stock) + p.context.stock_from) +
      text(", resolution %.4g mm, tolerance %.4g mm</p>\n", p.removal.cell, p.verdict.tolerance);
  if (!p.verdict.unseen.empty()) html += "<p class='sub'>Not seen: " + escaped(p.verdict.unseen) + "</p>\n";
  if (good) return html;
  html += "<ul class='bad-list'>";
  for (const std::string& failure : p.verdict.failures) html += "<li>" + escaped(failure) + "</li>\n";
  if (!p.verdict.rest.empty()) html += "<li>" + escaped(p.verdict.rest) + "</li>\n";
  return html + "</ul>\n";
}

std::string cards(const PageParts& p) {
  const Removal& r = p.removal;
  const auto hits = [&](TroubleKind kind) {
    return std::count_if(r.troubles.begin(), r.troubles.end(),
                         [&](const Trouble& t) { return t.kind == kind; });
  };
  std::string html = "<div class='cards'>\n";
  html += card(text("%.4f mm", p.verdict.gouge), "largest gouge");
  html += card(text("%.4f mm", r.excess[3]), "left on half of the surface cut");
  html += card(text("%.4f mm", r.excess[5]), "left on 95 % of it, or less");
  html += card(text("%td", hits(TroubleKind::kStockHit)), "hits of shank or holder");
  html +=
      card(text("%td", hits(TroubleKind::kRapidPart) + hits(TroubleKind::kRapidStock)), "rapids that touch");
  const auto posted = p.context.header.seconds;
  html += card(clock_text(r.seconds),
               posted ? "machining time; the post foresaw " + clock_text(*posted) : "machining time");
  html += card(text("%.1f %%", r.feed_seconds > 0.0 ? 100.0 * r.air_seconds / r.feed_seconds : 0.0),
               "of feed time in air");
  html += card(text("%.1f cm³", (r.stock_volume - r.left_volume) / 1000.0), "removed");
  html +=
      card(text("%.1f m", r.feed_length / 1000.0), text("feed path, %.1f m rapids", r.rapid_length / 1000.0));
  html += card(text("%llu", static_cast<unsigned long long>(r.blocks)), "moves");
  return html + "</div>\n";
}

std::string excess_table(const Removal& r) {
  std::string first, second;
  for (std::size_t k = 0; k < kPercentiles.size(); ++k) {
    first += text("<th class='n'>%.0f %%</th>", kPercentiles[k]);
    second += text("<td class='n'>%.4f</td>", r.excess[k]);
  }
  return "<div class='wide' tabindex='0'><table><tr><th>share of the surface cut</th>" + first +
         "</tr><tr><td>has this much left or less, mm</td>" + second +
         "</tr></table></div>\n<p class='sub'>" +
         text(
             "%.0f of the part's %.0f mm² came within %.3g mm of the cutter; %llu probes, %.3g mm "
             "apart.</p>\n",
             r.touched_area, r.area, r.reach, static_cast<unsigned long long>(r.probes), r.probe_spacing);
}

std::string travel_table(const Removal& r, const MachineModel& m) {
  const std::array<std::array<double, 2>, 5> limits{{{m.x.min, m.x.max},
                                                     {m.y.min, m.y.max},
                                                     {m.z.min, m.z.max},
                                                     {m.tilt.min, m.tilt.max},
                                                     {m.rotary.min, m.rotary.max}}};
  const char names[] = {'X', 'Y', 'Z', m.tilt.letter, m.rotary.letter};
  std::string html =
      "<div class='wide' tabindex='0'><table><tr><th>axis</th><th class='n'>from</th><th "
      "class='n'>to</th><th class='n'>travel from</th><th "
      "class='n'>to</th>"
      "<th class='n'>used</th></tr>\n";
  for (std::size_t k = 0; k < limits.size(); ++k)
    html += text(
        "<tr><td>%c</td><td class='n'>%.3f</td><td class='n'>%.3f</td><td class='n'>%.6g</td><td "
        "class='n'>%.6g</td><td class='n'>%.1f %%</td></tr>\n",
        names[k], r.travel_low[k], r.travel_high[k], limits[k][0], limits[k][1],
        100.0 * (r.travel_high[k] - r.travel_low[k]) / (limits[k][1] - limits[k][0]));
  return html + "</table></div>\n";
}

}  // namespace

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '&':
        out += "&amp;";
        break;
      case '\'':
        out += "&#39;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string report_page(const PageParts& p) {
  const ViewerFiles viewer = viewer_files();
  const bool moving = !viewer.script_gzip.empty() && !p.view.empty();
  std::string html =
      "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
      "<meta http-equiv='Content-Security-Policy' content=\"default-src 'none'; img-src data:; style-src "
      "'unsafe-inline'" +
      (moving ? "; script-src '" + std::string(viewer.script_hash) + "'" : std::string()) +
      "; base-uri 'none'; form-action 'none'\">"
      "<meta name='viewport' content='width=device-width,initial-scale=1'><title>";
  html += escaped(p.context.job.plan.name) + ": " + p.verdict.word() + "</title><style>" + kStyle +
          std::string(moving ? viewer.style : "") + "</style></head><body><main>\n";
  html += head(p);
  if (moving) html += "<section id='report-viewer' aria-label='Viewer'></section>\n";
  html += cards(p) + places_html(p);
  html +=
      "<section id='picture'><h2>What is left on the part</h2>\n" +
      figure(p.deviation_png, "the part coloured by what is left on it",
             "Each facet in the colour of the material left on it along its normal; rings: worst places.") +
      legend(p.scale) + "</section>\n<h2>How much is left</h2>\n" + excess_table(p.removal);
  html += "<h2>Path</h2>\n" +
          figure(p.path_png, "the part with the path over it",
                 "Feed moves from yellow (first) to crimson (last), rapids dashed, tool axes dark.");
  html +=
      "<h2>Over time</h2>\n<p class='sub'>moves:<span class='key cutting'></span>cutting"
      "<span class='key air'></span>feed in air<span class='key rapid'></span>rapid</p>\n" +
      timeline_svg(p.removal);
  html +=
      "<h2>Axes</h2>\n<p class='sub'>Place between the least and the most of each span of time, and the "
      "largest speed; dashed: the machine's limits.</p>\n" +
      axes_svg(p.removal, p.context.job.machine.model) + travel_table(p.removal, p.context.job.machine.model);
  html += "</main>\n";
  if (moving)
    html += "<script type='text/plain' id='cut-view'>" + base64(p.view) + "</script>\n<script>" +
            unzipped(viewer.script_gzip) + "</script>\n";
  return html + "</body></html>\n";
}

}  // namespace tiltfeed::sim
