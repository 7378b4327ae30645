#pragma once
// Engagement over time as a picture: feed, load, angle and removal.

#include <string>
#include <vector>

namespace tiltfeed::sim {

/// What is drawn of a span at feed.
struct PlottedSpan {
  unsigned operation = 1;
  double seconds = 0.0;  ///< machine time
  double feed = 0.0;     ///< of the tip while it runs, mm/min
  double load = 0.0;     ///< edge load as the machine runs; drawn as a share of the operation's largest
  double angle = 0.0;    ///< degrees
  double rate = 0.0;     ///< removal, mm^3/min
};

/// One row of a table that write_engagement() made; nothing: the line is no such row.
bool plotted_span(const std::string& line, PlottedSpan& span);

/// SVG. `before`: of the program that it is compared with, drawn grey over the same scale; may be empty.
/// Property: the same bytes for the same numbers.
std::string engagement_svg(const std::vector<PlottedSpan>& now, const std::vector<PlottedSpan>& before);

}  // namespace tiltfeed::sim
