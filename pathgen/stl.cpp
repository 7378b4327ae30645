#include "pathgen/stl.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>
#include <unistd.h>

#include <algorithm>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>

#include "pathgen/read_blocks.h"
#include "pathgen/stl_text.h"

namespace tiltfeed {
namespace {

static_assert(std::endian::native == std::endian::little, "binary STL is read and written by copying");

// Binary STL: 80 bytes of header, a 32-bit count, then records of 12 floats and a 16-bit attribute.
constexpr std::uint64_t kHeaderBytes = 80;
constexpr std::uint64_t kDataStart = 84;
constexpr std::uint64_t kRecordBytes = 50;
constexpr std::uint64_t kNormalBytes = 12;
/// Fewer bytes after the last record than one more record would need can hide no facet.
constexpr std::uint64_t kMaxTrailingBytes = kRecordBytes - 1;

using Range = tbb::blocked_range<std::uint64_t>;
/// Facets that one task takes at least: some hundred microseconds of work.
constexpr std::uint64_t kGrain = 8192;

/// Closes on every way out.
class FileDescriptor {
 public:
  explicit FileDescriptor(int fd) : fd_(fd) {}
  ~FileDescriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  int get() const { return fd_; }
  /// False when the close reports a write error.
  bool close() { return ::close(std::exchange(fd_, -1)) == 0; }

 private:
  int fd_;
};

std::string number(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 7).ptr;
  return {text, end};
}

tl::unexpected<Error> io_error(const std::string& path, const std::string& what) {
  return fail(Code::kIo, path + ": " + what + ": " + std::strerror(errno));
}

std::uint32_t facet_count(std::span<const char> bytes) {
  std::uint32_t count = 0;
  std::memcpy(&count, bytes.data() + kHeaderBytes, sizeof count);
  return count;
}

/// Why bytes that are neither ASCII STL nor a binary STL of the right size are refused.
tl::unexpected<Error> misfit(std::span<const char> bytes, const std::string& name) {
  const std::uint64_t size = bytes.size();
  const std::string not_stl =
      name + ": this is not an STL file: it is no text that begins with \"solid\", and ";
  if (size < kDataStart) {
    return fail(Code::kInput, not_stl + "its " + std::to_string(size) +
                                  " bytes are fewer than the 84 of a binary header; export the part again");
  }
  const std::uint64_t count = facet_count(bytes);
  const std::uint64_t whole = (size - kDataStart) / kRecordBytes;
  const std::uint64_t over = (size - kDataStart) % kRecordBytes;
  if (count > kMaxFacets && whole < kMaxFacets) {
    return fail(Code::kInput, not_stl + "bytes 80 to 83 would mean " + std::to_string(count) +
                                  " facets in a file of " + std::to_string(size) +
                                  " bytes; export the part again as STL");
  }
  const std::string found = std::to_string(count) + " facets (" +
                            std::to_string(kDataStart + count * kRecordBytes) + " bytes), but the file is " +
                            std::to_string(size) + " bytes: " + std::to_string(whole) + " whole facets and " +
                            std::to_string(over) + " bytes";
  return fail(Code::kInput, name + ": the binary header says " + found +
                                (count > whole ? "; the file is cut short or its count is too high"
                                               : "; its count is too low") +
                                "; export or copy the part again");
}

Result<Stl> parse_binary(std::span<const char> bytes, const std::string& name) {
  const std::uint64_t count = facet_count(bytes);
  if (count == 0) {
    return fail(Code::kInput, name + ": the binary header says 0 facets; export the part again");
  }
  if (count > kMaxFacets) {
    return fail(Code::kLimit, name + ": " + std::to_string(count) + " facets are over the limit of " +
                                  std::to_string(kMaxFacets) + "; export with a coarser tolerance");
  }
  Stl stl;
  stl.binary = true;
  stl.facets.resize(count);
  tbb::parallel_for(Range(0, count, kGrain), [&](const Range& range) {
    for (std::uint64_t i = range.begin(); i < range.end(); ++i) {
      float c[9];
      std::memcpy(c, bytes.data() + kDataStart + i * kRecordBytes + kNormalBytes, sizeof c);
      stl.facets[i] = {{{c[0], c[1], c[2]}, {c[3], c[4], c[5]}, {c[6], c[7], c[8]}}};
    }
  });
  const std::uint64_t trailing = bytes.size() - kDataStart - count * kRecordBytes;
  if (trailing > 0) {
    stl.warnings.push_back(name + ": " + std::to_string(trailing) +
                           " bytes after the last facet are ignored");
  }
  return stl;
}

/// Facets that may not stay, and the first of them.
struct Refused {
  std::uint64_t count = 0, first = 0;
  void add(std::uint64_t facet) {
    if (count++ == 0) first = facet;
  }
  /// Of the facets after these.
  void add(const Refused& later) {
    if (count == 0) first = later.first;
    count += later.count;
  }
};

/// Scales to mm and checks every coordinate.
Result<Stl> scaled(Stl stl, const std::string& name, double unit_mm) {
  const auto beyond = [](Point<Part> p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) > kMaxCoordinate;
  };
  struct Findings {
    Refused not_finite, too_far;
  };
  const auto [not_finite, too_far] = tbb::parallel_reduce(
      Range(0, stl.facets.size(), kGrain), Findings{},
      [&](const Range& range, Findings found) {
        for (std::uint64_t i = range.begin(); i < range.end(); ++i) {
          std::array<Point<Part>, 3>& facet = stl.facets[i];
          const bool finite =
              std::all_of(facet.begin(), facet.end(), [](Point<Part> p) { return is_finite(p); });
          for (Point<Part>& p : facet) p = {p.x * unit_mm, p.y * unit_mm, p.z * unit_mm};
          if (!finite)
            found.not_finite.add(i);
          else if (std::any_of(facet.begin(), facet.end(), beyond))
            found.too_far.add(i);
        }
        return found;
      },
      [](Findings a, const Findings& b) {
        a.not_finite.add(b.not_finite), a.too_far.add(b.too_far);
        return a;
      });
  if (not_finite.count > 0) {
    return fail(Code::kMesh, name + ": " + std::to_string(not_finite.count) +
                                 " facets have NaN or infinite coordinates, the first is facet " +
                                 std::to_string(not_finite.first) + "; repair the part and export it again");
  }
  if (too_far.count > 0) {
    const std::array<Point<Part>, 3>& facet = stl.facets[too_far.first];
    const Point<Part> far_corner = *std::find_if(facet.begin(), facet.end(), beyond);
    return fail(Code::kMesh, name + ": " + std::to_string(too_far.count) +
                                 " facets lie beyond the limit of " + number(kMaxCoordinate) +
                                 " mm, the first is facet " + std::to_string(too_far.first) + " at " +
                                 to_string(far_corner) + " mm with a unit of " + number(unit_mm) +
                                 " mm; check the unit of the file, or move the part to its origin");
  }
  return stl;
}

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

std::string to_string(Point<Part> p) {
  return "(" + number(p.x) + ", " + number(p.y) + ", " + number(p.z) + ")";
}

Result<Stl> parse_stl(std::span<const char> bytes, const std::string& name, double unit_mm) {
  if (!std::isfinite(unit_mm) || unit_mm <= 0.0) {
    return fail(Code::kInput, name + ": a unit of " + number(unit_mm) +
                                  " mm is not a length; give the length of the file's unit in mm");
  }
  if (bytes.empty()) return fail(Code::kInput, name + ": the file is empty; export the part again");
  if (bytes.size() > kMaxStlBytes) {
    return fail(Code::kLimit, name + ": " + std::to_string(bytes.size()) + " bytes are over the limit of " +
                                  std::to_string(kMaxStlBytes) + "; export with a coarser tolerance");
  }
  const std::string_view text(bytes.data(), bytes.size());
  // The size rule comes first: no text below kMaxStlBytes can satisfy it, since four bytes of text as a
  // count are over 150 million facets, while many binary headers begin with "solid".
  const bool fits = bytes.size() >= kDataStart &&
                    bytes.size() >= kDataStart + facet_count(bytes) * kRecordBytes &&
                    bytes.size() - kDataStart - facet_count(bytes) * kRecordBytes <= kMaxTrailingBytes;
  Result<Stl> stl = fits                        ? parse_binary(bytes, name)
                    : looks_like_text_stl(text) ? parse_text_stl(text, name)
                                                : misfit(bytes, name);
  if (!stl) return stl;
  return scaled(std::move(*stl), name, unit_mm);
}

Result<Stl> read_stl(const std::string& path, double unit_mm) {
  // O_NONBLOCK: a FIFO must be refused below, not waited for.
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) return io_error(path, "cannot open");
  struct stat info {};
  if (::fstat(file.get(), &info) != 0) return io_error(path, "cannot read");
  if (!S_ISREG(info.st_mode)) return fail(Code::kIo, path + ": cannot read: not a regular file");
  const auto size = static_cast<std::uint64_t>(info.st_size);
  if (size > kMaxStlBytes) {
    return fail(Code::kLimit, path + ": " + std::to_string(size) + " bytes are over the limit of " +
                                  std::to_string(kMaxStlBytes) + "; export with a coarser tolerance");
  }
  const auto buffer = std::make_unique_for_overwrite<char[]>(size);
  const auto filled = read_blocks(file.get(), buffer.get(), size);
  if (!filled) return io_error(path, "cannot read");
  return parse_stl({buffer.get(), *filled}, path, unit_mm);
}

Result<void> write_stl(const std::string& path, const std::vector<std::array<Point<Part>, 3>>& facets) {
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

  const std::string beside = path + "." + std::to_string(::getpid()) + ".part";
  FileDescriptor file(::open(beside.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666));
  if (file.get() < 0) return io_error(beside, "cannot create");
  const bool written = write_all(file.get(), data) && ::fsync(file.get()) == 0;
  const int write_errno = errno;
  if (!written || !file.close() || ::rename(beside.c_str(), path.c_str()) != 0) {
    if (!written) errno = write_errno;
    auto error = io_error(path, "cannot write");
    ::unlink(beside.c_str());
    return error;
  }
  return {};
}

}  // namespace tiltfeed
