#pragma once
// A disk in memory for the journal: what was not made durable may be lost, in part or out of order; any
// operation can fail on request.

#include <cerrno>
#include <cstdint>
#include <memory>
#include <random>
#include <string>

#include "daemon/journal.h"

namespace tiltfeed {

struct SimulatedDisk {
  std::string file;     // as a running process sees it
  std::string durable;  // as of the last sync
  int operations = 0;
  int fail_at = -1;   // this operation fails, and all later ones
  int failure = EIO;  // with this; 0: a short write (disk full)
  bool lies = false;  // sync says yes and does nothing
  std::size_t short_by = 1;

  bool fails() { return fail_at >= 0 && operations++ >= fail_at; }

  /// What is there after a power loss: all that was durable, and of the rest any 16-byte pieces.
  std::string after_power_loss(std::mt19937_64& random) const {
    std::string left = durable;
    if (file.size() > durable.size()) {
      std::string tail = file.substr(durable.size());
      for (std::size_t i = 0; i < tail.size(); i += 16)
        if (random() % 2 == 0)
          tail.replace(i, std::min<std::size_t>(16, tail.size() - i),
                       std::min<std::size_t>(16, tail.size() - i), '\0');
      left += tail.substr(0, random() % (tail.size() + 1));
    }
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
  out.append = [disk](std::string_view bytes) -> std::ptrdiff_t {
    if (!disk->fails()) {
      disk->file += bytes;
      return static_cast<std::ptrdiff_t>(bytes.size());
    }
    if (disk->failure != 0) return -disk->failure;
    const std::size_t taken = bytes.size() - std::min(bytes.size(), disk->short_by);
    disk->file += bytes.substr(0, taken);
    return static_cast<std::ptrdiff_t>(taken);
  };
  out.truncate = [disk](std::uint64_t size) {
    if (disk->fails()) return -EIO;
    disk->file.resize(size);
    if (disk->durable.size() > size) disk->durable.resize(size);
    return 0;
  };
  out.sync = [disk] {
    if (disk->fails()) return -EIO;
    if (!disk->lies) disk->durable.append(disk->file, disk->durable.size());
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
