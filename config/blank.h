#pragma once
// What a job is cut from: its section `blank`.

#include <optional>
#include <string>

#include "config/description.h"
#include "config/section.h"

namespace tiltfeed::config {

enum class BlankShape {
  kBox,       ///< the part's box along the part's axes, `margin` larger on every side
  kCylinder,  ///< round about the table's direction through the middle of the part's box, `margin` larger
  kFile       ///< a mesh file in the part's coordinates
};

struct Blank {
  BlankShape shape = BlankShape::kBox;
  double margin = 0.0;   ///< mm
  std::string path;      ///< of the file, resolved against the job file's folder
  double unit_mm = 1.0;  ///< length of the file's unit
};

/// Nothing where the job has no such section.
std::optional<Blank> read_blank(const Section& root, const std::string& path);
void describe_blank(Description& out, const std::optional<Blank>& blank);

}  // namespace tiltfeed::config
