// The program `tiltfeed-cad`: a STEP or IGES file to facets, one file a run. OpenCASCADE lives and dies here.

#include <CLI/CLI.hpp>
#include <cstdio>
#include <iostream>
#include <new>
#include <nlohmann/json.hpp>

#include "cad/shape/iges_file.h"
#include "cad/shape/last_words.h"
#include "cad/shape/step_file.h"
#include "cad/shape/tessellate.h"
#include "config/command_line.h"
#include "config/output_file.h"
#include "config/standard_output.h"
#include "config/version.h"
#include "kinematics/basics/decimal.h"
#include "pathgen/mesh/stl.h"
#include "pathgen/part_file/cad_stream.h"
#include "pathgen/part_file/file_kind.h"

namespace {

using namespace tiltfeed;
using namespace tiltfeed::cad;

constexpr int kDone = 0, kFailed = 1, kWrongUse = 2;
constexpr double kUsualDeviation = 0.002;  // mm

struct Options {
  std::string file, stream, stl;
  std::vector<std::string> bodies;
  double deviation = kUsualDeviation;
  int memory_mb = 0, seconds = 0;
  bool json = false;
};

int report(const Error& error) {
  std::cerr << "tiltfeed-cad: " << error.message << "\n";
  return error.code == Code::kUsage ? kWrongUse : kFailed;
}

Result<LoadedPart> load(const std::string& file) {
  switch (pathgen::format_of_file(file)) {
    case pathgen::PartFormat::kStep:
      return load_step(file);
    case pathgen::PartFormat::kIges:
      return load_iges(file);
    default:
      return fail(Code::kInput, file + ": this is no STEP or IGES file, or it cannot be read");
  }
}

/// The bodies that are asked for, before they are meshed.
Result<void> choose(LoadedPart& part, const std::vector<std::string>& names, const std::string& file) {
  pathgen::PartModel model;
  for (const LoadedBody& body : part.bodies) model.bodies.push_back({body.name, body.product, body.closed});
  for (std::uint32_t i = 0; i < part.bodies.size(); ++i) {
    pathgen::PartFace face;
    face.body = i, face.entity = part.bodies[i].name;
    model.faces.push_back(face);
  }
  if (auto kept = pathgen::keep_bodies(model, names, file); !kept) return kept;
  std::vector<LoadedBody> chosen;
  for (LoadedBody& body : part.bodies)
    for (const pathgen::PartFace& face : model.faces)
      if (face.entity == body.name) {
        chosen.push_back(std::move(body));
        break;
      }
  part.bodies = std::move(chosen);
  return {};
}

std::string body_text(const pathgen::PartModel& model, const std::vector<pathgen::FaceFacets>& facets) {
  std::string text;
  for (const std::string& note : pathgen::notes_on(model)) text += note + "\n";
  for (std::uint32_t i = 0; i < model.bodies.size(); ++i) {
    std::size_t faces = 0, count = 0;
    double deviation = 0.0;
    for (std::size_t f = 0; f < model.faces.size(); ++f)
      if (model.faces[f].body == i)
        ++faces, count += facets[f].facets.size(), deviation = std::max(deviation, model.faces[f].deviation);
    text += "body \"" + model.bodies[i].name + "\": " + (model.bodies[i].closed ? "solid" : "surface") +
            ", " + std::to_string(faces) + " faces, " + std::to_string(count) + " facets, deviation " +
            decimal(deviation, 5) + " mm\n";
  }
  for (const std::string& warning : model.mesh.warnings) text += "warning: " + warning + "\n";
  return text;
}

std::string json_text(const pathgen::PartModel& model, const std::vector<pathgen::FaceFacets>& facets) {
  nlohmann::ordered_json json = {{"format", model.format},
                                 {"unit", model.unit},
                                 {"unit_mm", model.unit_mm},
                                 {"allowed_mm", model.allowed},
                                 {"deviation_mm", model.deviation}};
  json["bodies"] = nlohmann::ordered_json::array(), json["faces"] = nlohmann::ordered_json::array();
  for (const pathgen::PartBody& body : model.bodies)
    json["bodies"].push_back({{"name", body.name}, {"product", body.product}, {"solid", body.closed}});
  for (std::size_t i = 0; i < model.faces.size(); ++i) {
    const pathgen::PartFace& face = model.faces[i];
    json["faces"].push_back({{"body", model.bodies[face.body].name},
                             {"name", face.name},
                             {"colour", face.colour ? pathgen::colour_text(*face.colour) : ""},
                             {"surface", face.surface},
                             {"entity", face.entity},
                             {"facets", facets[i].facets.size()},
                             {"deviation_mm", face.deviation}});
  }
  json["warnings"] = model.mesh.warnings;
  return json.dump(1, ' ', true, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

int run(const Options& options) {
  if (const auto fits = config::check_outputs({{"--stl", options.stl}, {"--stream", options.stream}},
                                              {{"FILE", options.file}});
      !fits)
    return report(fits.error());
  limit_resources(options.memory_mb, options.seconds);
  hear_faults();
  auto part = load(options.file);
  if (!part) return report(part.error());
  if (auto chosen = choose(*part, options.bodies, options.file); !chosen) return report(chosen.error());
  const auto made = tessellate(*part, options.deviation, options.file);
  if (!made) return report(made.error());
  if (!options.stream.empty())
    if (auto kept = config::write_file(options.stream, pathgen::cad_stream(made->model, made->facets)); !kept)
      return report(kept.error());
  if (!options.stl.empty()) {
    std::vector<std::array<Point<Part>, 3>> facets;
    for (const pathgen::FaceFacets& face : made->facets)
      for (const auto& [a, b, c] : face.facets)
        facets.push_back({face.corners[a], face.corners[b], face.corners[c]});
    if (auto kept = pathgen::write_stl(options.stl, facets); !kept) return report(kept.error());
  }
  (options.stream == "-" ? std::cerr : std::cout)
      << (options.json             ? json_text(made->model, made->facets)
          : options.stream.empty() ? body_text(made->model, made->facets)
                                   : "");
  return kDone;
}

int parsed(int argc, char** argv) {
  CLI::App app{
      "Reads a STEP or IGES file and makes facets of its surfaces, within a distance that is measured.\n"
      "tiltfeed starts it for parts in these formats."};
  app.set_version_flag("--version", "tiltfeed-cad " + config::version());
  Options options;
  app.add_option("FILE", options.file, "STEP or IGES file")->required();
  app.add_option("--body", options.bodies,
                 "take this body, by its name or its product's; may be repeated (default: all)");
  app.add_option("--deviation", options.deviation,
                 "largest distance of facets from their surfaces, mm (default 0.002)")
      ->check(CLI::Range(1e-5, 10.0));
  app.add_option("--stl", options.stl, "facets to write, as a binary STL");
  app.add_option("--stream", options.stream,
                 "facets, faces and bodies to write, for tiltfeed; '-': standard output");
  app.add_option("--memory-mb", options.memory_mb, "end when it needs more memory")
      ->check(CLI::Range(0, 1 << 20));
  app.add_option("--seconds", options.seconds, "end when it needs more processor time")
      ->check(CLI::Range(0, 1 << 20));
  app.add_flag("--json", options.json, "print bodies and faces as one JSON object");
  if (argc == 2 && std::string_view(argv[1]) == config::kDescribeWord) {
    std::cout << config::command_json(config::describe_command_line(app, "tiltfeed-cad")) << "\n";
    return kDone;
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return config::report_parse_end(app, error) ? kDone : kWrongUse;
  }
  try {
    return run(options);
  } catch (const std::bad_alloc&) {
    return report({Code::kLimit, options.file + ": out of memory while " + at_now() +
                                     "; choose bodies, or use a larger tolerance_mm"});
  } catch (const std::exception& failure) {
    return report({Code::kInput, options.file + ": failed while " + at_now() + ": " + failure.what()});
  }
}

}  // namespace

int main(int argc, char** argv) {
  tiltfeed::config::open_standard_streams();
  return tiltfeed::config::close_standard_output("tiltfeed-cad", parsed(argc, argv));
}
