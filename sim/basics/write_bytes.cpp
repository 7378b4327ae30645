#include "sim/basics/write_bytes.h"

#include "config/output_file.h"

namespace tiltfeed::sim {

Result<void> write_bytes(const std::string& path, const std::string& bytes) {
  return config::write_file(path, bytes);
}

}  // namespace tiltfeed::sim
