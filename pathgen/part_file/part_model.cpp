#include "pathgen/part_file/part_model.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <set>

#include "kinematics/basics/decimal.h"

namespace tiltfeed::pathgen {
namespace {

constexpr std::size_t kMostListed = 12;

/// At most kMostListed of them, in quotes, each once.
std::string listed(const std::vector<std::string>& names) {
  std::set<std::string> told;
  std::string text;
  for (const std::string& name : names) {
    if (name.empty() || !told.insert(name).second) continue;
    if (told.size() > kMostListed) return text + ", ...";
    text += (text.empty() ? "\"" : ", \"") + name + "\"";
  }
  return text.empty() ? "none" : text;
}

}  // namespace

std::string colour_text(std::uint32_t colour) {
  std::array<char, 8> text{};
  std::snprintf(text.data(), text.size(), "#%06x", static_cast<unsigned>(colour & 0xffffffu));
  return text.data();
}

Result<void> keep_bodies(PartModel& model, const std::vector<std::string>& names, const std::string& file) {
  if (names.empty()) return {};
  if (model.bodies.empty())
    return fail(Code::kInput, file + ": a mesh file has no bodies to choose from; remove part.bodies");
  std::vector<bool> kept(model.bodies.size(), false);
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t i = 0; i < kept.size(); ++i)
      if (model.bodies[i].name == name || model.bodies[i].product == name) kept[i] = found = true;
    if (found) continue;
    std::vector<std::string> all;
    for (const PartBody& body : model.bodies) all.push_back(body.name);
    return fail(Code::kInput, file + ": no body has the name \"" + name + "\"; there are " + listed(all));
  }
  PartModel rest = model;
  rest.mesh.facets.clear(), rest.face_of.clear(), rest.faces.clear(), rest.bodies.clear();
  std::vector<std::uint32_t> body_now(kept.size(), 0), face_now(model.faces.size(), 0);
  for (std::size_t i = 0; i < kept.size(); ++i) {
    body_now[i] = static_cast<std::uint32_t>(rest.bodies.size());
    if (kept[i]) rest.bodies.push_back(model.bodies[i]);
  }
  rest.deviation = 0.0;
  for (std::size_t i = 0; i < model.faces.size(); ++i) {
    face_now[i] = static_cast<std::uint32_t>(rest.faces.size());
    if (!kept[model.faces[i].body]) continue;
    rest.faces.push_back(model.faces[i]);
    rest.faces.back().body = body_now[model.faces[i].body];
    rest.deviation = std::max(rest.deviation, model.faces[i].deviation);
  }
  for (std::size_t i = 0; i < model.mesh.facets.size(); ++i) {
    const std::uint32_t face = model.face_of[i];
    if (!kept[model.faces[face].body]) continue;
    rest.mesh.facets.push_back(model.mesh.facets[i]);
    rest.face_of.push_back(face_now[face]);
  }
  model = std::move(rest);
  return {};
}

Result<std::vector<bool>> faces_named(const PartModel& model, const std::vector<std::string>& names,
                                      const std::string& file) {
  if (model.faces.empty())
    return fail(Code::kInput,
                file + ": a mesh file has no faces with names or colours; take a STEP, IGES or 3MF file");
  std::vector<bool> chosen(model.faces.size(), false);
  for (const std::string& name : names) {
    bool found = false;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      const PartFace& face = model.faces[i];
      if (face.name == name || (face.colour && colour_text(*face.colour) == name)) chosen[i] = found = true;
    }
    if (found) continue;
    std::vector<std::string> all, colours;
    for (const PartFace& face : model.faces) {
      all.push_back(face.name);
      if (face.colour) colours.push_back(colour_text(*face.colour));
    }
    return fail(Code::kInput, file + ": no face has the name or colour \"" + name +
                                  "\"; names: " + listed(all) + "; colours: " + listed(colours));
  }
  return chosen;
}

std::vector<std::string> notes_on(const PartModel& model) {
  if (model.format.empty()) return {};
  std::string text = model.format + " file";
  if (!model.unit.empty())
    text += " in " + model.unit +
            (model.unit_mm == 1.0 ? "" : ", taken as " + number_text(model.unit_mm, 7) + " mm each");
  std::vector<std::string> names;
  for (const PartBody& body : model.bodies) names.push_back(body.name);
  text += ": " + std::to_string(model.bodies.size()) + (model.bodies.size() == 1 ? " body, " : " bodies, ") +
          listed(names);
  if (!model.faces.empty()) text += "; " + std::to_string(model.faces.size()) + " faces";
  std::vector<std::string> notes = {text};
  if (model.allowed > 0.0)
    notes.push_back("facets leave the surfaces by " + decimal(model.deviation, 5) +
                    " mm at most (measured), allowed " + decimal(model.allowed, 5) + " mm");
  return notes;
}

}  // namespace tiltfeed::pathgen
