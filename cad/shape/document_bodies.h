#pragma once
// The bodies of an XDE document: where they stand, their names and their faces' colours.

#include <functional>
#include <string>
#include <vector>

#include "cad/shape/loaded_part.h"

class TDocStd_Document;

namespace tiltfeed::cad {

/// What the file says of a shape: its entity, "#12 ADVANCED_FACE", and the entity's own name.
struct ShapeSource {
  std::string entity, name;
};
using SourceOf = std::function<ShapeSource(const TopoDS_Shape&)>;

/// Solids, and what is no solid, in the order of the assembly. A body has the product's name; where the
/// product has several, that of its own entity, or a number behind a colon. A face's colour is its own, else
/// its body's, else its product's.
std::vector<LoadedBody> bodies_of(const TDocStd_Document& document, const SourceOf& source_of);

}  // namespace tiltfeed::cad
