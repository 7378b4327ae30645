#pragma once
// A disk in memory for the journal: what was not made durable may be lost, in part or out of order; any
// operation can fail on request.

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <memory>
#include <random>
#include <string>

#include "daemon/journal/journal.h"

namespace tiltfeed {
using namespace daemon;

struct SimulatedDisk {
  std::string file;     // as a running process sees it
  std::string durable;  // as of the last sync
  int operations = 0;
  int fail_at = -1;   // this operation fails, and all later ones
  int failure = EIO;  // with this; 0: a short write (disk full)
  bool lies = false;  // sync says yes and does nothing
  std::size_t short_by = 1;

  bool fails() { return fail_at >= 0 && operations++ >= fail_at; }

  /// What is there after a power loss: all that was durable, and of what came later any pieces, as large as a
  /// sector or smaller.
  std::string after_power_loss(std::mt19937_64& random) const {
    std::string left = durable;
    const std::size_t grown = file.size() - std::min(file.size(), durable.size());
    left.resize(durable.size() + (grown > 0 ? random() % (grown + 1) : 0), '\0');
    const std::size_t piece = random() % 2 == 0 ? 16 : 512;
    for (std::size_t at = 0; at < left.size(); at += piece)
      if (random() % 2 == 0) left.replace(at, piece, file, at, std::min(piece, left.size() - at));
    return left;
  }
};

inline JournalDisk journal_disk(const std::shared_ptr<SimulatedDisk>& disk) {
  JournalDisk out;
  out.name = "simulated";
  out.read = [disk]() -> Result<std::string> {
    if (disk->fails()) return fail(Code::kIo, "simulated: cannot be read");
    return disk->file;
  };
  out.write = [disk](std::uint64_t at, std::string_view bytes) -> std::ptrdiff_t {
    const bool fails = disk->fails();
    if (fails && disk->failure != 0) return -disk->failure;
    const std::size_t taken = bytes.size() - (fails ? std::min(bytes.size(), disk->short_by) : 0);
    disk->file.resize(std::max<std::size_t>(disk->file.size(), at + taken), '\0');
    disk->file.replace(at, taken, bytes.substr(0, taken));
    return static_cast<std::ptrdiff_t>(taken);
  };
  out.sync = [disk] {
    if (disk->fails()) return -EIO;
    if (!disk->lies) disk->durable = disk->file;
    return 0;
  };
  out.replace = [disk](std::string_view content) {
    if (disk->fails()) return -EIO;
    disk->file = disk->durable = content;
    return 0;
  };
  return out;
}

}  // namespace tiltfeed
