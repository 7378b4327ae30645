#pragma once
// STL files, binary and ASCII, told apart by content, not by name or header.

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "kinematics/basics/geometry.h"
#include "kinematics/basics/result.h"

namespace tiltfeed {

/// The facets in file order, scaled to mm, unwelded. Normals of the file are ignored: corners decide.
/// Coordinates are the file's float32 values (text is rounded to float32 too), scaled in double.
struct Stl {
  std::vector<std::array<Point<Part>, 3>> facets;
  bool binary = false;
  std::vector<std::string> warnings;  ///< oddities that do no harm: trailing bytes, several solids
};

inline constexpr std::uint64_t kMaxStlBytes = 512ull << 20;
inline constexpr std::uint32_t kMaxFacets = 5'000'000;
/// Largest coordinate in any direction, mm: beyond it the unit is wrong, and float32 is coarser than 1 um.
inline constexpr double kMaxCoordinate = 10'000.0;

/// "(1.5, -2, 0.25)", to seven digits: how messages name a place.
std::string to_string(Point<Part> p);

/// `unit_mm`: length of the file's unit in mm. `name` goes into messages. Facets count from 0, lines from 1.
/// Errors, with place and remedy: kInput: empty, truncated, count that does not fit the size, no facets,
/// decimal commas, malformed numbers or text, not an STL, unit not positive; kMesh: NaN/Inf coordinates
/// (count and first facet) or coordinates beyond kMaxCoordinate; kLimit: over kMaxStlBytes or kMaxFacets.
Result<Stl> parse_stl(std::span<const char> bytes, const std::string& name, double unit_mm);
/// The same from a regular file; kIo when it cannot be read.
Result<Stl> read_stl(const std::string& path, double unit_mm);

/// A binary STL, coordinates rounded to float32; `path` names it in messages. Errors: kInput as below.
Result<std::string> stl_bytes(const std::string& path, const std::vector<std::array<Point<Part>, 3>>& facets);

/// Writes it beside `path` and renames it into place; on any
/// error nothing is left behind and a file that was there stays as it was.
/// Errors: kInput: no facets, over kMaxFacets, or a coordinate that is no float32; kIo.
Result<void> write_stl(const std::string& path, const std::vector<std::array<Point<Part>, 3>>& facets);

}  // namespace tiltfeed
