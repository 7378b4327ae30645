#include "sim/parts/parts.h"

namespace tiltfeed::sim {

Result<Triangles> part_by_name(const std::string& name) {
  if (name == "tyre") return tyre_segment();
  if (name == "pin") return cooling_pin();
  if (name == "sphere") return hollow_sphere();
  if (name == "handle") return handle();
  return fail(Code::kUsage, "there is no built-in part '" + name + "'; use tyre, pin, sphere or handle");
}

}  // namespace tiltfeed::sim
