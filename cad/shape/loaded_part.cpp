#include "cad/shape/loaded_part.h"

#include <TopoDS_Shape.hxx>

namespace tiltfeed::cad {

LoadedBody::LoadedBody() = default;
LoadedBody::LoadedBody(LoadedBody&&) noexcept = default;
LoadedBody& LoadedBody::operator=(LoadedBody&&) noexcept = default;
LoadedBody::~LoadedBody() = default;

std::string name_of(const LoadedBody& body, std::size_t face) {
  const std::string& entity = body.faces[face].entity;
  return "body \"" + body.name + "\", " + (entity.empty() ? "face " + std::to_string(face + 1) : entity);
}

}  // namespace tiltfeed::cad
