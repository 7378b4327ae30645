#pragma once
// Which format a part's file has: its content decides, not its name.

#include <span>
#include <string>

namespace tiltfeed::pathgen {

enum class PartFormat {
  kMesh,     ///< STL, OBJ, PLY, or none of all: read_stl() says which
  kStep,     ///< ISO 10303-21
  kIges,     ///< fixed lines of 80
  kThreeMf,  ///< a ZIP archive
};

/// Bytes that format_of() looks at; fewer only where the file is shorter.
inline constexpr std::size_t kFormatBytes = 256;

PartFormat format_of(std::span<const char> head);
/// Of a file; kMesh where it cannot be read.
PartFormat format_of_file(const std::string& path);
/// Are the file's surfaces made into facets here? STEP and IGES.
inline bool has_surfaces(PartFormat format) {
  return format == PartFormat::kStep || format == PartFormat::kIges;
}

}  // namespace tiltfeed::pathgen
