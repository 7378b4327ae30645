#pragma once
// The report as one page for people: everything inside of it, nothing fetched; a viewer, where this program
// was built with the page.

#include <string>
#include <string_view>
#include <vector>

#include "sim/report/deviation_picture.h"

namespace tiltfeed::sim {

/// Lines of the program round a place, for a place.
struct Excerpt {
  std::vector<std::string> lines;
  std::size_t marked = 0;  ///< which of them is the place's
};

/// A row of the table of worst places.
struct WorstPlace {
  std::string what, amount;  ///< the amount in mm
  bool wrong = true;         ///< not passed; or only told
  std::uint64_t block = 0;
  std::uint32_t line = 0, facet = kNoFacet;
  Point<Part> place;
  double time = 0.0;  ///< s
};

/// What fails, troubles first, in their order, then the feed that is too fast; then where more is left than
/// the job asks for.
std::vector<WorstPlace> worst_places(const Removal& removal, const RemovalVerdict& verdict);

struct PageParts {
  const RemovalContext& context;
  const Removal& removal;
  const RemovalVerdict& verdict;
  const std::vector<ColourStop>& scale;
  std::string deviation_png, path_png;  ///< bytes
  std::vector<Excerpt> excerpts;        ///< by worst place
  std::string_view view = {};           ///< for the viewer; empty: none
};

std::string report_page(const PageParts& parts);
/// The worst places as a table, with links to their lines.
std::string places_html(const PageParts& parts);

/// Text with the characters that HTML reserves written out.
std::string escaped(const std::string& text);
/// "1:23:45" of seconds.
std::string clock_text(double seconds);

/// SVG of the run over time: removal rate, what the machine does, where troubles are.
std::string timeline_svg(const Removal& removal);
/// SVG of each axis over time, place and speed, with its limits.
std::string axes_svg(const Removal& removal, const MachineModel& machine);

}  // namespace tiltfeed::sim
