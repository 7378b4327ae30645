#include "sim/report/report_page.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "sim/basics/text.h"

namespace tiltfeed::sim {
namespace {

constexpr const char* kStyle = R"(
:root{color-scheme:light}body{margin:0;background:#f3f4f6;color:#1c232b;font:15px/1.5 system-ui,'DejaVu Sans',sans-serif}
main{max-width:1120px;margin:0 auto;padding:24px}h1{font-size:26px;margin:0}h2{font-size:18px;margin:34px 0 10px}
.verdict{display:inline-block;padding:3px 14px;border-radius:4px;color:#fff;font-weight:700;letter-spacing:.06em;margin-left:14px;vertical-align:3px;font-size:16px}
.good{background:#1d7a3e}.bad{background:#b3132b}.part{background:#b36b00}.sub{color:#55606c;margin:4px 0 0}
.cards{display:grid;grid-template-columns:repeat(auto-fit,minmax(190px,1fr));gap:10px;margin-top:18px}
.card{background:#fff;border:1px solid #d9dde2;border-radius:6px;padding:10px 14px}.card b{display:block;font-size:21px;font-variant-numeric:tabular-nums}.card span{color:#55606c;font-size:13px}
table{border-collapse:collapse;width:100%;background:#fff;border:1px solid #d9dde2;font-variant-numeric:tabular-nums}
th,td{padding:6px 10px;text-align:left;border-bottom:1px solid #e6e9ec}th{background:#e9ecef;font-size:13px}td.n,th.n{text-align:right}
img,svg{width:100%;height:auto;display:block;background:#fff;border:1px solid #d9dde2;border-radius:6px}
figure{margin:0}figcaption{color:#55606c;font-size:13px;margin-top:6px}ul.bad-list{background:#fdeced;border:1px solid #e9b5bc;border-radius:6px;padding:10px 14px 10px 34px}
pre{background:#20262d;color:#dfe5ea;padding:10px 14px;border-radius:6px;overflow:auto;font-size:13px;line-height:1.45}pre mark{background:#8c1126;color:#fff}
details{margin:8px 0}summary{cursor:pointer}
.plot{fill:#fbfcfd;stroke:#c9ced4}.rate{fill:#2e6fb2}.cutting{fill:#2f8a57}.air{fill:#d9a520}.rapid{fill:#8aa0b4}.place{fill:#2e6fb2;stroke:#2e6fb2;stroke-width:.8}.speed{fill:#76879a}
.limit{stroke:#b3132b;stroke-width:1.2;stroke-dasharray:6 4}.trouble{stroke:#b3132b;stroke-width:1.6}
svg text{font:12px system-ui,'DejaVu Sans',sans-serif;fill:#3b4550}svg .name{font-weight:700}svg .unit,svg .tick,svg .hour{fill:#6a7683;font-size:11px}svg .tick{text-anchor:end}svg .hour{text-anchor:middle}
.key{display:inline-block;width:12px;height:12px;border-radius:2px;margin:0 5px 0 14px;vertical-align:-1px}
)";

std::string base64(const std::string& bytes) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve(bytes.size() * 4 / 3 + 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t word = 0;
    for (std::size_t k = 0; k < 3; ++k)
      word = word << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k)
      out += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63U] : '=';
  }
  return out;
}

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
  return "<table><tr><th>share of the surface cut</th>" + first +
         "</tr><tr><td>has this much left or less, mm</td>" + second + "</tr></table>\n<p class='sub'>" +
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
      "<table><tr><th>axis</th><th class='n'>from</th><th class='n'>to</th><th class='n'>travel from</th><th "
      "class='n'>to</th>"
      "<th class='n'>used</th></tr>\n";
  for (std::size_t k = 0; k < limits.size(); ++k)
    html += text(
        "<tr><td>%c</td><td class='n'>%.3f</td><td class='n'>%.3f</td><td class='n'>%.6g</td><td "
        "class='n'>%.6g</td><td class='n'>%.1f %%</td></tr>\n",
        names[k], r.travel_low[k], r.travel_high[k], limits[k][0], limits[k][1],
        100.0 * (r.travel_high[k] - r.travel_low[k]) / (limits[k][1] - limits[k][0]));
  return html + "</table>\n";
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
  std::string html =
      "<!DOCTYPE html>\n<html lang='en'><head><meta charset='utf-8'>"
      "<meta name='viewport' content='width=device-width,initial-scale=1'><title>";
  html += escaped(p.context.job.plan.name) + ": " + p.verdict.word() + "</title><style>" + kStyle +
          "</style></head><body><main>\n";
  html += head(p) + cards(p) + places_html(p);
  html +=
      "<h2>What is left on the part</h2>\n" +
      figure(p.deviation_png, "the part coloured by what is left on it",
             "Each facet in the colour of the material left on it along its normal; rings: worst places.") +
      legend(p.scale) + excess_table(p.removal);
  html += "<h2>Path</h2>\n" +
          figure(p.path_png, "the part with the path over it",
                 "Feed moves from yellow (first) to crimson (last), rapids dashed, tool axes dark.");
  html +=
      "<h2>Over time</h2>\n<p class='sub'>moves:<span class='key' style='background:#2f8a57'></span>cutting"
      "<span class='key' style='background:#d9a520'></span>feed in air<span class='key' "
      "style='background:#8aa0b4'></span>rapid</p>\n" +
      timeline_svg(p.removal);
  html +=
      "<h2>Axes</h2>\n<p class='sub'>Place between the least and the most of each span of time, and the "
      "largest speed; dashed: the machine's limits.</p>\n" +
      axes_svg(p.removal, p.context.job.machine.model) + travel_table(p.removal, p.context.job.machine.model);
  return html + "</main></body></html>\n";
}

}  // namespace tiltfeed::sim
