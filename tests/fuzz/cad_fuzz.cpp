// Text of STEP and IGES files, and the stream of tiltfeed-cad: errors say something, what is taken is whole.

#include "cad/text/iges_text.h"
#include "cad/text/step_text.h"
#include "pathgen/part_file/cad_stream.h"
#include "pathgen/part_file/file_kind.h"
#include "tests/fuzz/fuzz.h"

FUZZ_TARGET(cad) {
  using namespace tiltfeed;
  const std::string text(bytes);
  pathgen::format_of(std::span(bytes.data(), bytes.size()));
  const auto step = cad::check_step_text(text, "fuzz.step");
  if (step) {
    HOLDS(!step->types.empty());
    for (std::size_t i = 1; i < step->types.size(); ++i)
      HOLDS(step->types[i - 1].first < step->types[i].first);
  } else {
    HOLDS(step.error().message.starts_with("fuzz.step: "));
  }
  if (const auto iges = cad::check_iges_text(text, "fuzz.iges"); !iges)
    HOLDS(iges.error().message.starts_with("fuzz.iges:"));
  const auto stream = pathgen::read_cad_stream(std::span(bytes.data(), bytes.size()), "fuzz");
  if (stream) HOLDS(stream->face_of.size() == stream->mesh.facets.size());
}
