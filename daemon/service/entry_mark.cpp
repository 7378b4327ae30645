#include "daemon/service/entry_mark.h"

#include <algorithm>
#include <fstream>

#include "config/output_file.h"
#include "daemon/protocol/session.h"

namespace tiltfeed::daemon {

Result<void> write_entry_mark(const std::string& file, const EntryMark& mark) {
  return config::write_file(file, std::to_string(mark.job) + " " + std::to_string(mark.from) + " " +
                                      std::to_string(mark.total) + "\n");
}

std::optional<EntryMark> read_entry_mark(const std::string& file) {
  std::ifstream in(file);
  EntryMark mark;
  if (in >> mark.job >> mark.from >> mark.total) return mark;
  return std::nullopt;
}

std::string entered_range(const EntryMark& mark, std::uint64_t executed, std::uint64_t may_have,
                          std::uint64_t total) {
  const std::string of = "of job " + std::to_string(mark.job) + " ";
  // Blocks of the way in, which comes before those of the entered job.
  const std::uint64_t rest = mark.total - std::min(mark.from - 1, mark.total);
  const std::uint64_t way = total - std::min(rest, total);
  if (may_have <= way) return of + "none has run again";
  const std::uint64_t before = mark.from - 1;
  const auto there = [&](std::uint64_t block) { return block - std::min(way, block) + before; };
  if (may_have <= executed) return of + numbered("block", {mark.from, there(executed)}) + " ran again";
  return of + "that is " + numbered("block", {std::max(there(executed) + 1, mark.from), there(may_have)});
}

}  // namespace tiltfeed::daemon
