#include "sim/basics/text.h"
#include "sim/report/report_page.h"

namespace tiltfeed::sim {
namespace {

std::string row(std::size_t number, const WorstPlace& w) {
  return text(
      "<tr><td><a href='#trouble-%zu'>%zu</a></td><td>%s</td><td class='n'>%s</td><td class='n'>%llu</td>"
      "<td class='n'>%u</td><td class='n'>%s</td><td>%.3f, %.3f, %.3f</td><td class='n'>%s</td></tr>\n",
      number, number, w.what.c_str(), w.amount.c_str(), static_cast<unsigned long long>(w.block), w.line,
      w.facet == kNoFacet ? "" : std::to_string(w.facet).c_str(), w.place.x, w.place.y, w.place.z,
      clock_text(w.time).c_str());
}

/// The program's lines round a place.
std::string details(std::size_t number, const WorstPlace& w, const Excerpt* excerpt) {
  constexpr std::size_t kOpen = 3;
  std::string html =
      text("<details id='trouble-%zu'%s><summary>%zu: block %llu, line %u, %s</summary><pre tabindex='0'>",
           number, w.wrong && number <= kOpen ? " open" : "", number,
           static_cast<unsigned long long>(w.block), w.line, w.what.c_str());
  for (std::size_t k = 0; excerpt != nullptr && k < excerpt->lines.size(); ++k) {
    const std::string line = escaped(excerpt->lines[k]);
    html += (k == excerpt->marked ? "<mark>" + line + "</mark>" : line) + "\n";
  }
  return html + "</pre></details>\n";
}

}  // namespace

std::vector<WorstPlace> worst_places(const Removal& r, const RemovalVerdict& verdict) {
  std::vector<WorstPlace> places;
  for (const Trouble& t : r.troubles)
    places.push_back({std::string(kTroubleNames[static_cast<int>(t.kind)]) + ": " +
                          kToolPartNames[static_cast<int>(t.tool)],
                      text("%.4f deep", t.depth), true, t.block, t.line, t.facet, t.place, t.time});
  if (r.haste.moves > 0) {
    const std::string of = r.haste.moves > 1
                               ? text(", of %llu moves", static_cast<unsigned long long>(r.haste.moves))
                               : std::string();
    places.push_back({text("feed too fast: %.0f mm/min at the tip", r.haste.feed) + of,
                      text("%.4f ahead", r.haste.ahead), true, r.haste_block, r.haste_line, kNoFacet,
                      r.haste.place, r.haste_time});
  }
  for (const Leftover& l : r.most_left)
    if (l.left > verdict.excess_limit)
      places.push_back({"material left, nearest move", text("%.4f left", l.left), false, l.block, l.line,
                        l.facet, l.place, l.time});
  return places;
}

std::string places_html(const PageParts& p) {
  const std::vector<WorstPlace> places = worst_places(p.removal, p.verdict);
  std::string html = "<h2>Worst places</h2>\n";
  if (p.removal.troubles.empty())
    html += "<p>Nothing is cut that must not be, and nothing touches." +
            (p.removal.gouge.depth > 0.0 ? " The deepest cut into the part, within the tolerance: " +
                                               escaped(trouble_text(p.removal.gouge)) + "."
                                         : "") +
            "</p>\n";
  if (places.empty()) return html;
  html +=
      "<div class='wide' tabindex='0'><table><tr><th>#</th><th>what</th><th class='n'>mm</th><th "
      "class='n'>block</th><th "
      "class='n'>line</th><th class='n'>facet</th><th>place, mm</th><th class='n'>time</th></tr>\n";
  for (std::size_t i = 0; i < places.size(); ++i) html += row(i + 1, places[i]);
  html +=
      text("</table></div>\n<p class='sub'>More left than %.3g mm is not told apart.</p>\n", p.removal.reach);
  for (std::size_t i = 0; i < places.size(); ++i)
    html += details(i + 1, places[i], i < p.excerpts.size() ? &p.excerpts[i] : nullptr);
  return html;
}

}  // namespace tiltfeed::sim
