#pragma once
// What a service says, as values of MTConnect's data items.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "daemon/mtconnect/data_items.h"

namespace tiltfeed::daemon {

/// By the item's id; a condition's is `level|native code|severity|qualifier|text`. Every item has one.
using Observations = std::map<std::string, std::string>;

inline constexpr const char* kUnavailable = "UNAVAILABLE";

/// What is known of the service at one time.
struct ServiceView {
  std::string job;          ///< JSON of the job on the machine, as `show` gives it; empty: none is
  std::string last;         ///< JSON of the newest run that ended, of `history`; empty: there was none
  std::string block;        ///< text of the first line that is not surely executed; empty: not known
  std::uint64_t parts = 0;  ///< runs that came to their end
};

/// Nothing: the service does not answer, and nothing is said but that. Properties: what the service does not
/// know is UNAVAILABLE; the line is the first that is not surely
/// executed; a run that was held, a fault, an alarm and a run that did not
/// end are conditions with the service's own words. Errors: kIo: an answer that is not understood.
Result<Observations> observe(const std::vector<DataItem>& items, const std::optional<ServiceView>& view);

/// The lines (SHDR 1) that tell an agent of what is new in `now`, or of all where `before` is null: samples
/// and events on one line, each condition on its own. `time`: as 2026-01-31T23:59:59.125Z.
std::string shdr_lines(const std::vector<DataItem>& items, const Observations* before,
                       const Observations& now, const std::string& time);

}  // namespace tiltfeed::daemon
