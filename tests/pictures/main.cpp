// pictures CHECKOUT: writes the pictures of the rooms' READMEs where they belong.

#include <cstdio>
#include <string>

#include "tests/pictures/pictures.h"

namespace {

struct Picture {
  const char* file;
  tiltfeed::Result<void> (*draw)(const std::string& file);
};
constexpr Picture kPictures[] = {
    {"pathgen/surface/cl_surface.svg", tiltfeed::pictures::draw_cl_surface},
    {"pathgen/axis/deformation.svg", tiltfeed::pictures::draw_deformation},
    {"pathgen/envelope/envelope.svg", tiltfeed::pictures::draw_envelope},
    {"pathgen/free_axis/directions.svg", tiltfeed::pictures::draw_directions},
    {"kinematics/joints/singularity_bend.svg", tiltfeed::pictures::draw_pole_bend},
    {"daemon/protocol/window.svg", tiltfeed::pictures::draw_window},
};

}  // namespace

int main(int count, char** arguments) {
  if (count != 2) {
    std::fprintf(stderr, "usage: pictures CHECKOUT\n");
    return 2;
  }
  for (const Picture& picture : kPictures) {
    const std::string file = std::string(arguments[1]) + "/" + picture.file;
    if (const auto drawn = picture.draw(file); !drawn) {
      std::fprintf(stderr, "%s: %s\n", file.c_str(), drawn.error().message.c_str());
      return 1;
    }
    std::printf("%s\n", picture.file);
  }
  return 0;
}
