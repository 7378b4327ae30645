// Which patches of shank and holder matter on a line of the envelope. (G3) in pathgen/pattern/README.md.

#include "pathgen/envelope/envelope.h"
#include "pathgen/envelope/pass_floor.h"

namespace tiltfeed::pathgen {

/// Finds where patches of shank and holder can be higher than what the cutting part has there, or where that
/// has nothing, for `guards_`; false if nowhere.
bool Envelope::find_guards(const FlatLine& line, const PassFloor& floor) {
  const HullBvh& tree = index_.guards();
  scratch_.pieces.clear();
  guards_.clear();
  tree.each(
      box_round(line),
      [&](const FlatBox& box, float top) {
        double from, to;
        return run_in_box(box, line, from, to) && floor.lowest(from, to) < static_cast<double>(top);
      },
      [&](const HullBvh::Found& found) {
        Candidate c;
        if (!index_.seen_along(found, line.dx, line.dy).meets(line, c)) return;
        floor.each_below(c.from, c.to, static_cast<double>(c.top), [&](double from, double to) {
          scratch_.pieces.push_back({from, to, c.patch, c.top});
        });
      });
  join_pieces(scratch_.pieces, guards_);
  return !guards_.empty();
}

}  // namespace tiltfeed::pathgen
