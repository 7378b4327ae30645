#include "pathgen/options/rest_reason.h"

#include <array>

namespace tiltfeed::pathgen {

namespace {

struct Words {
  const char *word, *remedy;
};
constexpr std::array<Words, kRestReasons> kWords{
    {{"cutter", "use a smaller cutter"},
     {"shank", "use a longer cutter.cutting_length_mm or a thinner shank"},
     {"holder", "use a longer cutter.shank_length_mm"},
     {"tilt", "turn the part on the table"},
     {"containment", "widen the containment"},
     {"wall", "cut it with z-level contours, or let the passes go deeper"},
     {"fixture", "clamp the part elsewhere, or use a longer or thinner tool"}}};

}  // namespace

const char* word_of(RestReason why) { return kWords[static_cast<std::size_t>(why)].word; }
const char* remedy(RestReason why) { return kWords[static_cast<std::size_t>(why)].remedy; }

}  // namespace tiltfeed::pathgen
