// LineReader text: no live byte reaches a wire, no line is too long, a second pass finds the same.

#include <sys/mman.h>
#include <unistd.h>

#include <vector>

#include "daemon/program/line_reader.h"
#include "daemon/program/numeric_block.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::daemon;

FUZZ_TARGET(gcode) {
  static const int fd = ::memfd_create("fuzz", 0);
  HOLDS(::ftruncate(fd, 0) == 0);
  HOLDS(::pwrite(fd, bytes.data(), bytes.size(), 0) == static_cast<ssize_t>(bytes.size()));
  auto program = LineReader::open("/proc/self/fd/" + std::to_string(fd));
  HOLDS(program);
  const auto facts = program->survey();
  if (!facts) return HOLDS(!facts.error().message.empty());
  BlockReader reader;
  std::vector<NumericBlock> blocks;
  Line line;
  std::uint64_t lines = 0;
  bool readable = true;
  for (auto more = program->next(line); more && *more; more = program->next(line)) {
    ++lines;
    HOLDS(!line.text.empty() && line.text.size() <= kMaxLine);
    for (const char c : line.text) HOLDS(c > ' ' && c < 0x7F && c != '!' && c != '?' && c != '~' && c != '$');
    readable = readable && reader.read(line, blocks);
    if (blocks.size() > 1000) blocks.clear();
  }
  HOLDS(lines == facts->lines);
}
