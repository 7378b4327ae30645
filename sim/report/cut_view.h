#pragma once
// What the viewer shows of a removal run: the part with what is left on it, the stock over time, the tool,
// the verdict, the worst places.

#include <string>
#include <vector>

#include "sim/report/deviation_picture.h"
#include "sim/report/report_page.h"

namespace tiltfeed::sim {

struct CutViewParts {
  const RemovalContext& context;
  const Removal& removal;
  const RemovalVerdict& verdict;
  const ExecutedPath& path;
  const Probes& probes;
  const StockFilm* film;  ///< null: none
  const std::vector<ColourStop>& scale;
  const std::vector<Excerpt>& excerpts;  ///< by worst place
};

/// More patches than this are not shown: the page would be too large to send. No browser shows them well.
inline constexpr std::size_t kMostShownPatches = 2'000'000;

/// Compressed numbers (sim/viewer/packed_view.h); what they are is in sim/viewer/README.md. Empty: the part
/// has too many patches. The same bytes for the same run.
std::string cut_view(const CutViewParts& parts);

}  // namespace tiltfeed::sim
