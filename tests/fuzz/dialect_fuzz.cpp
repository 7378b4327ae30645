// LineReader text of every dialect, read back: the first byte chooses the dialect.

#include <cmath>
#include <sstream>

#include "daemon/post/nc_reader.h"
#include "tests/fuzz/fuzz.h"

using namespace tiltfeed;
using namespace tiltfeed::config;
using namespace tiltfeed::daemon;

FUZZ_TARGET(dialect) {
  if (bytes.empty()) return;
  TextLanguage language;
  const auto choice = static_cast<unsigned char>(bytes[0]);
  language.dialect = kDialects[choice % kDialects.size()].dialect;
  std::istringstream in{std::string(bytes.substr(1))};
  const auto text = read_nc_program(in, "fuzz.nc", language);
  if (!text) return HOLDS(text.error().message.find("fuzz.nc") != std::string::npos);
  HOLDS(!text->operations.empty());
  for (const TextOperation& operation : text->operations) {
    HOLDS(!operation.blocks.empty());
    for (const TextBlock& block : operation.blocks) {
      HOLDS(std::isfinite(block.words.x) && std::isfinite(block.words.y) && std::isfinite(block.words.z));
      HOLDS(std::isfinite(block.words.a) && std::isfinite(block.words.c) && std::isfinite(block.feed));
      HOLDS(block.rapid || block.feed > 0.0);
    }
    for (const auto& event : operation.events) HOLDS(event.move <= operation.blocks.size());
  }
}
