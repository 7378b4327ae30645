#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <string_view>

#include "pathgen/mesh/file_descriptor.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/mesh/stl_layout.h"

namespace tiltfeed::pathgen {
namespace {

/// One record: normal, corners, attribute 0.
void append_record(std::string& out, const std::array<Point<Part>, 3>& facet) {
  const Vec3 across = cross(facet[1] - facet[0], facet[2] - facet[0]);
  const double size = length(across);
  const Vec3 normal = size > 0.0 ? across / size : Vec3{};
  float values[12] = {static_cast<float>(normal.x), static_cast<float>(normal.y),
                      static_cast<float>(normal.z)};
  for (int k = 0; k < 3; ++k) {
    values[3 + 3 * k] = static_cast<float>(facet[k].x);
    values[4 + 3 * k] = static_cast<float>(facet[k].y);
    values[5 + 3 * k] = static_cast<float>(facet[k].z);
  }
  const std::uint16_t attribute = 0;
  out.append(reinterpret_cast<const char*>(values), sizeof values);
  out.append(reinterpret_cast<const char*>(&attribute), sizeof attribute);
}

bool write_all(int fd, std::string_view data) {
  while (!data.empty()) {
    const ssize_t written = ::write(fd, data.data(), data.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    data.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

Result<std::string> stl_bytes(const std::string& path,
                              const std::vector<std::array<Point<Part>, 3>>& facets) {
  if (facets.empty()) return fail(Code::kInput, path + ": there are no facets to write");
  if (facets.size() > kMaxFacets) {
    return fail(Code::kInput, path + ": " + std::to_string(facets.size()) + " facets are over the limit of " +
                                  std::to_string(kMaxFacets));
  }
  std::string data(kHeaderBytes, '\0');
  data.replace(0, 19, "Tiltfeed binary STL");
  data.reserve(kDataStart + facets.size() * kRecordBytes);
  const auto count = static_cast<std::uint32_t>(facets.size());
  data.append(reinterpret_cast<const char*>(&count), sizeof count);
  for (std::size_t i = 0; i < facets.size(); ++i) {
    for (const Point<Part>& p : facets[i]) {
      const bool is_float = std::isfinite(static_cast<float>(p.x)) &&
                            std::isfinite(static_cast<float>(p.y)) && std::isfinite(static_cast<float>(p.z));
      if (!is_float) {
        return fail(Code::kInput, path + ": facet " + std::to_string(i) + " has a corner at " + to_string(p) +
                                      ": no float32");
      }
    }
    append_record(data, facets[i]);
  }
  return data;
}

Result<void> write_stl(const std::string& path, const std::vector<std::array<Point<Part>, 3>>& facets) {
  const auto data = stl_bytes(path, facets);
  if (!data) return tl::unexpected(data.error());
  const std::string beside = path + "." + std::to_string(::getpid()) + ".part";
  FileDescriptor file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) return io_error(beside, "cannot create");
  const bool written = write_all(file.get(), *data) && ::fsync(file.get()) == 0;
  const int write_errno = errno;
  if (!written || !file.close() || ::rename(beside.c_str(), path.c_str()) != 0) {
    if (!written) errno = write_errno;
    auto error = io_error(path, "cannot write");
    ::unlink(beside.c_str());
    return error;
  }
  return {};
}

}  // namespace tiltfeed::pathgen
