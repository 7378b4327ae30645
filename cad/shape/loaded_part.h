#pragma once
// What a CAD file holds, as OpenCASCADE has read it: bodies with their faces, in mm.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

class TopoDS_Shape;

namespace tiltfeed::cad {

struct FaceFacts {
  std::string name;
  std::optional<std::uint32_t> colour;  ///< 0xRRGGBB
  std::string entity;                   ///< "#12 ADVANCED_FACE"; may be empty
};

/// One solid, or a surface that is none.
struct LoadedBody {
  LoadedBody();
  LoadedBody(LoadedBody&&) noexcept;
  LoadedBody& operator=(LoadedBody&&) noexcept;
  ~LoadedBody();
  std::string name;     ///< no other body has it
  std::string product;  ///< what the assembly calls it
  bool closed = true;
  std::unique_ptr<TopoDS_Shape> shape;  ///< where it stands, mm
  std::vector<FaceFacts> faces;         ///< in the order in which TopExp_Explorer visits them
};

/// As messages name a face: body "lid", #12 ADVANCED_FACE.
std::string name_of(const LoadedBody& body, std::size_t face);

struct LoadedPart {
  std::string format, unit;
  double unit_mm = 1.0;
  std::vector<std::string> warnings;
  std::vector<LoadedBody> bodies;  ///< at least one
};

}  // namespace tiltfeed::cad
