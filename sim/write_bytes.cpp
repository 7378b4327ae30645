#include "sim/write_bytes.h"

#include <fstream>

namespace tiltfeed::sim {

Result<void> write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary | std::ios::trunc);
  if (!(out << bytes << std::flush))
    return fail(Code::kIo, path + ": cannot be written; is the folder there and writable?");
  return {};
}

}  // namespace tiltfeed::sim
