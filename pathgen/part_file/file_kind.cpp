#include "pathgen/part_file/file_kind.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <string_view>

#include "pathgen/mesh/file_descriptor.h"

namespace tiltfeed::pathgen {
namespace {

constexpr std::size_t kIgesColumn = 72;  // of the section's letter

/// A line's end within the first 80 columns and a bit: lines of IGES are as long as that.
bool is_iges(std::string_view text) {
  if (text.size() < kIgesColumn + 8) return false;
  const std::string_view number = text.substr(kIgesColumn + 1, 7);
  return text[kIgesColumn] == 'S' && number.find_first_not_of(" 0") == 6 && number[6] == '1';
}

}  // namespace

PartFormat format_of(std::span<const char> head) {
  std::string_view text(head.data(), head.size());
  if (text.starts_with("PK\x03\x04")) return PartFormat::kThreeMf;
  if (is_iges(text)) return PartFormat::kIges;
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first != text.npos && text.substr(first).starts_with("ISO-10303-21")) return PartFormat::kStep;
  return PartFormat::kMesh;
}

PartFormat format_of_file(const std::string& path) {
  // O_NONBLOCK: a FIFO is not waited for.
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  if (file.get() < 0) return PartFormat::kMesh;
  std::array<char, kFormatBytes> head;
  const ssize_t got = ::pread(file.get(), head.data(), head.size(), 0);
  if (got <= 0) return PartFormat::kMesh;
  return format_of({head.data(), static_cast<std::size_t>(got)});
}

}  // namespace tiltfeed::pathgen
