#include "cad/shape/loaded_part.h"

#include <TopoDS_Shape.hxx>

namespace tiltfeed::cad {

LoadedBody::LoadedBody() = default;
LoadedBody::LoadedBody(LoadedBody&&) noexcept = default;
LoadedBody& LoadedBody::operator=(LoadedBody&&) noexcept = default;
LoadedBody::~LoadedBody() = default;

}  // namespace tiltfeed::cad
