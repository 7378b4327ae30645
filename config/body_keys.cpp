#include "config/body_keys.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>

#include "config/enum_words.h"
#include "config/key_ranges.h"

namespace tiltfeed::config {
namespace {

// Ranges: any machine that people stand beside; a body thinner than a hundredth of a mm is a slip.
constexpr Range kSize{0.01, 100'000.0};   // mm
constexpr Range kPoint{0.0, 100'000.0};   // mm; a cone may end in a point
constexpr Range kAngle{-360.0, 360.0};    // degrees
constexpr Range kClearance{0.0, 1000.0};  // mm
constexpr Range kFactor{1.0, 100.0};
constexpr Range kUnit{1e-4, 1e4};  // mm; a tenth of a micrometre to ten metres
constexpr std::size_t kMostBodies = 200;

constexpr Words<BodyLink> kLinkWords = {
    {"bed", BodyLink::kBed},        {"x_slide", BodyLink::kXSlide}, {"y_slide", BodyLink::kYSlide},
    {"z_slide", BodyLink::kZSlide}, {"table", BodyLink::kTable},    {"cradle", BodyLink::kCradle},
    {"fork", BodyLink::kFork},      {"head", BodyLink::kHead},      {"nose", BodyLink::kNose}};
constexpr Words<SolidKind> kSolidWords = {{"box", SolidKind::kBox},
                                          {"cylinder", SolidKind::kCylinder},
                                          {"cone", SolidKind::kCone},
                                          {"stl", SolidKind::kStl}};
constexpr Words<bool> kOnWords = {{"table", false}, {"part", true}};
constexpr std::array<const char*, 3> kAxisWords{"x", "y", "z"};

/// Cosine and sine of an angle in degrees, exact for multiples of 90.
std::array<double, 2> turn(double degrees) {
  constexpr std::array<std::array<double, 2>, 4> kQuarters{{{1, 0}, {0, 1}, {-1, 0}, {0, -1}}};
  const double quarters = degrees / 90.0;
  if (quarters == std::floor(quarters)) return kQuarters[(static_cast<int>(quarters) % 4 + 4) % 4];
  const double angle = Angle::from_degrees(degrees).radians();
  return {std::cos(angle), std::sin(angle)};
}

std::string read_colour(const Section& item) {
  const std::string colour = item.text("colour", kNoColour);
  const auto hex = [](unsigned char c) { return std::isxdigit(c) != 0; };
  if (colour.size() == 7 && colour[0] == '#' && std::all_of(colour.begin() + 1, colour.end(), hex))
    return colour;
  item.complain("colour", "expected \"#rrggbb\", six hexadecimal digits in quotes, found " + quoted(colour));
  return kNoColour;
}

/// Complains about keys of the other kinds of solid.
void refuse_others(const Section& item, SolidKind kind) {
  struct Use {
    const char* key;
    std::initializer_list<SolidKind> kinds;
  };
  const Use uses[] = {{"size_mm", {SolidKind::kBox}},
                      {"diameter_mm", {SolidKind::kCylinder, SolidKind::kCone}},
                      {"upper_diameter_mm", {SolidKind::kCone}},
                      {"height_mm", {SolidKind::kCylinder, SolidKind::kCone}},
                      {"stl", {SolidKind::kStl}},
                      {"unit", {SolidKind::kStl}}};
  for (const Use& use : uses)
    if (std::find(use.kinds.begin(), use.kinds.end(), kind) == use.kinds.end())
      item.unused(use.key, std::string("by the shape ") + word(kSolidWords, kind));
}

SolidShape read_shape(const Section& item, const std::string& path) {
  SolidShape shape;
  shape.kind = item.choice<SolidKind>("shape", kSolidWords);
  refuse_others(item, shape.kind);
  shape.at = item.vector("at_mm", kMachinePlace, Vec3{});
  shape.rotation = rotation_by_degrees(item.vector("rotation_deg", kAngle, Vec3{}));
  switch (shape.kind) {
    case SolidKind::kBox:
      shape.size = item.vector("size_mm", kSize);
      break;
    case SolidKind::kCone:
    case SolidKind::kCylinder:
      shape.diameter = item.number("diameter_mm", kSize);
      shape.height = item.number("height_mm", kSize);
      shape.upper_diameter =
          shape.kind == SolidKind::kCone ? item.number("upper_diameter_mm", kPoint) : shape.diameter;
      break;
    case SolidKind::kStl: {
      const std::string name = item.text("stl");
      shape.stl = beside_file(path, name);
      shape.stl_unit_mm = read_stl_unit(item);
      std::error_code error;
      if (item.has("stl") && !std::filesystem::is_regular_file(shape.stl, error))
        item.complain("stl", config::quoted(shape.stl) +
                                 " is not a file that can be read; expected an STL file, its "
                                 "path relative to this file");
      break;
    }
  }
  return shape;
}

/// Links that a machine of this structure has.
bool has_link(const MachineModel& model, BodyLink link) {
  if (link == BodyLink::kCradle) return model.structure == Structure::kTableTable;
  if (link == BodyLink::kFork) return model.structure == Structure::kHeadHead;
  return true;
}

std::vector<int> read_slides(const Section& section, const char* key) {
  std::vector<int> axes;
  for (const std::string& text : section.lines(key, 3)) {
    if (text == "none") continue;
    const auto at = std::find(kAxisWords.begin(), kAxisWords.end(), text);
    const int axis = static_cast<int>(at - kAxisWords.begin());
    if (at == kAxisWords.end() || std::find(axes.begin(), axes.end(), axis) != axes.end())
      section.complain(key, "expected none, or some of x, y, z, each once, found " + quoted(text));
    else
      axes.push_back(axis);
  }
  return axes;
}

void read_slides(const Section& root, MachineBodies& machine) {
  const Section slides = root.optional_section("slides", {"work", "tool"});
  machine.work_slides = read_slides(slides, "work");
  const auto carries_work = [&](int axis) {
    return std::find(machine.work_slides.begin(), machine.work_slides.end(), axis) !=
           machine.work_slides.end();
  };
  std::erase_if(machine.tool_slides, carries_work);
  if (!slides.has("tool")) return;
  const std::vector<int> tool = read_slides(slides, "tool");
  if (!std::is_permutation(tool.begin(), tool.end(), machine.tool_slides.begin(), machine.tool_slides.end()))
    slides.complain("tool", "expected each of x, y, z once in slides.work or in slides.tool");
  else
    machine.tool_slides = tool;
}

/// Names are told in messages, so each is there once.
template <class Item>
void check_names(const std::vector<Section>& sections, const std::vector<Item>& items) {
  for (std::size_t i = 0; i < items.size(); ++i)
    for (std::size_t k = 0; k < i; ++k)
      if (items[i].name == items[k].name)
        sections[i].complain("name", quoted(items[i].name) + " is there twice; expected a name of its own");
}

std::string text_of(const SolidShape& shape) {
  std::string text = std::string(", ") + word(kSolidWords, shape.kind);
  if (shape.kind == SolidKind::kStl) return text + " " + shape.stl;
  if (shape.kind == SolidKind::kBox)
    return text + " " + exact_text(shape.size.x) + " x " + exact_text(shape.size.y) + " x " +
           exact_text(shape.size.z) + " mm";
  return text + " of diameter " + exact_text(shape.diameter) +
         (shape.kind == SolidKind::kCone ? " to " + exact_text(shape.upper_diameter) : "") + ", height " +
         exact_text(shape.height) + " mm";
}

std::string text_of(const std::vector<int>& axes) {
  std::string text;
  for (const int axis : axes)
    text += (text.empty() ? "" : " ") + std::string(kAxisWords[static_cast<std::size_t>(axis)]);
  return text.empty() ? "none" : text;
}

}  // namespace

Rotation rotation_by_degrees(Vec3 degrees) {
  const auto [cx, sx] = turn(degrees.x);
  const auto [cy, sy] = turn(degrees.y);
  const auto [cz, sz] = turn(degrees.z);
  const Rotation about_x{{Vec3{1, 0, 0}, Vec3{0, cx, -sx}, Vec3{0, sx, cx}}};
  const Rotation about_y{{Vec3{cy, 0, sy}, Vec3{0, 1, 0}, Vec3{-sy, 0, cy}}};
  const Rotation about_z{{Vec3{cz, -sz, 0}, Vec3{sz, cz, 0}, Vec3{0, 0, 1}}};
  return about_z * about_y * about_x;
}

double read_stl_unit(const Section& section) {
  const std::string word = section.scalar("unit").value_or("");
  if (!section.has("unit") || word == "mm") return 1.0;
  if (word == "inch") return 25.4;
  if (word == "m") return 1000.0;
  if (word.find_first_of("0123456789") == std::string::npos)
    section.complain("unit",
                     "expected mm, inch, m or the unit's length as a number of mm, found " + quoted(word));
  return section.number("unit", kUnit);
}

std::string beside_file(const std::string& path, const std::string& name) {
  return (std::filesystem::path(path).parent_path() / name).lexically_normal().string();
}

MachineBodies read_bodies(const Section& root, const MachineModel& model, const std::string& path) {
  MachineBodies machine;
  read_slides(root, machine);
  const Section limits = root.optional_section(
      "clearances", {"cutter_mm", "shank_mm", "holder_mm", "head_mm", "table_mm", "rapid_factor"});
  Clearances& c = machine.clearances;
  c.cutter = limits.number("cutter_mm", kClearance, c.cutter);
  c.shank = limits.number("shank_mm", kClearance, c.shank);
  c.holder = limits.number("holder_mm", kClearance, c.holder);
  c.head = limits.number("head_mm", kClearance, c.head);
  c.table = limits.number("table_mm", kClearance, c.table);
  c.rapid_factor = limits.number("rapid_factor", kFactor, c.rapid_factor);
  const std::vector<Section> items =
      root.list("bodies",
                {"name", "link", "shape", "size_mm", "diameter_mm", "upper_diameter_mm", "height_mm", "stl",
                 "unit", "at_mm", "rotation_deg", "colour"},
                kMostBodies);
  for (const Section& item : items) {
    MachineBody body;
    body.name = item.name("name");
    body.link = item.choice<BodyLink>("link", kLinkWords);
    if (!has_link(model, body.link))
      item.complain("link", std::string(word(kLinkWords, body.link)) +
                                " is no link of this structure: table-table has a cradle, head-head a fork; "
                                "expected another link");
    body.colour = read_colour(item);
    body.shape = read_shape(item, path);
    machine.bodies.push_back(body);
  }
  check_names(items, machine.bodies);
  return machine;
}

std::vector<Fixture> read_fixtures(const Section& root, const std::string& path) {
  std::vector<Fixture> fixtures;
  const std::vector<Section> items =
      root.list("fixtures",
                {"name", "on", "shape", "size_mm", "diameter_mm", "upper_diameter_mm", "height_mm", "stl",
                 "unit", "at_mm", "rotation_deg", "colour"},
                kMostBodies);
  for (const Section& item : items) {
    Fixture fixture;
    fixture.name = item.name("name");
    fixture.on_part = item.choice<bool>("on", kOnWords, false);
    fixture.colour = read_colour(item);
    fixture.shape = read_shape(item, path);
    fixtures.push_back(fixture);
  }
  check_names(items, fixtures);
  return fixtures;
}

void describe_bodies(Description& out, const MachineBodies& machine) {
  if (machine.bodies.empty())
    return out.add("bodies", "none: the machine itself is not checked for collisions");
  for (std::size_t i = 0; i < machine.bodies.size(); ++i) {
    const MachineBody& body = machine.bodies[i];
    out.add("bodies[" + std::to_string(i + 1) + "]",
            body.name + " on the link " + word(kLinkWords, body.link) + text_of(body.shape));
  }
  out.add("slides.work", text_of(machine.work_slides));
  out.add("slides.tool", text_of(machine.tool_slides));
  const Clearances& c = machine.clearances;
  out.add("clearances.cutter_mm", c.cutter);
  out.add("clearances.shank_mm", c.shank);
  out.add("clearances.holder_mm", c.holder);
  out.add("clearances.head_mm", c.head);
  out.add("clearances.table_mm", c.table);
  out.add("clearances.rapid_factor", c.rapid_factor);
}

void describe_fixtures(Description& out, const std::vector<Fixture>& fixtures) {
  if (fixtures.empty()) out.add("fixtures", "none");
  for (std::size_t i = 0; i < fixtures.size(); ++i)
    out.add("fixtures[" + std::to_string(i + 1) + "]",
            fixtures[i].name + " on the " + word(kOnWords, fixtures[i].on_part) + text_of(fixtures[i].shape));
}

}  // namespace tiltfeed::config
