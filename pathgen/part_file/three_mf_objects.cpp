#include "pathgen/part_file/three_mf_objects.h"

#include <charconv>
#include <cmath>
#include <cstring>
#include <set>

#include "pathgen/mesh/stl_facets.h"
#include "pathgen/part_file/xml_walk.h"

namespace tiltfeed::pathgen {
namespace {

constexpr std::string_view kCore = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";
constexpr std::string_view kMaterials = "http://schemas.microsoft.com/3dmanufacturing/material/2015/02";
constexpr std::string_view kProduction = "http://schemas.microsoft.com/3dmanufacturing/production/2015/06";
// What they add is no shape, or is refused where it is used.
constexpr std::string_view kReadable[] = {
    kCore, kMaterials, kProduction, "http://schemas.microsoft.com/3dmanufacturing/2013/01/trianglesets",
    "http://schemas.microsoft.com/3dmanufacturing/trianglesets/2021/07"};

tl::unexpected<Error> wrong(const std::string& what) {
  return fail(Code::kInput, what + "; export the part again");
}

class Elements {
 public:
  explicit Elements(MfModel& model) : model_(model) {}

  void names_space(std::string_view prefix, std::string_view address) {
    addresses_[std::string(prefix)] = address;
  }

  Result<void> begin(std::string_view full, const XmlAttributes& a) {
    const std::size_t bar = full.rfind('|');
    const std::string_view space = bar == full.npos ? "" : full.substr(0, bar);
    const std::string_view name = bar == full.npos ? full : full.substr(bar + 1);
    if (space == kMaterials && (name == "colorgroup" || name == "color")) return colour(name, a);
    if (object_ != nullptr && name == "beamlattice")
      model_.warnings.push_back(here() + " has a beam lattice, which is left out");
    if (space != kCore) return {};
    if (name == "vertex") return vertex(a);
    if (name == "triangle") return triangle(a);
    if (name == "object") return object(a);
    if (name == "component") return component(a);
    if (name == "item") return item(a);
    if (name == "model") return root(a);
    if (name == "basematerials") return group(a);
    if (name == "base") {
      model_.materials.push_back({text(a, "name"), colour_of(text(a, "displaycolor"))});
      materials_[{group_, count_++}] = static_cast<std::uint32_t>(model_.materials.size());
    }
    return {};
  }

  Result<void> end(std::string_view full) {
    if (full == std::string(kCore) + "|object") {
      if (object_->corners.empty() && object_->components.empty() && object_->type != "other")
        return wrong("object " + std::to_string(id_) + " has neither a mesh nor components");
      object_ = nullptr;
    }
    return {};
  }

  bool found_model() const { return found_; }

 private:
  static std::string text(const XmlAttributes& a, std::string_view name) {
    const char* value = a.find(name);
    return value == nullptr ? "" : value;
  }
  template <class T>
  static std::optional<T> value(const XmlAttributes& a, std::string_view name) {
    const char* at = a.find(name);
    if (at == nullptr) return std::nullopt;
    T parsed{};
    const char* last = at + std::strlen(at);
    const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; };
    while (blank(*at)) ++at;
    while (last > at && blank(last[-1])) --last;
    if (*at == '+') ++at;
    const auto [end, error] = std::from_chars(at, last, parsed);
    if (error != std::errc{} || end != last) return std::nullopt;
    return parsed;
  }
  std::string here() const { return "object " + std::to_string(id_); }

  Result<void> root(const XmlAttributes& a) {
    found_ = true;
    if (const char* unit = a.find("unit")) model_.unit = unit;
    static const std::map<std::string, double> known = {{"micron", 1e-3},     {"millimeter", 1.0},
                                                        {"centimeter", 10.0}, {"inch", 25.4},
                                                        {"foot", 304.8},      {"meter", 1000.0}};
    const auto at = known.find(model_.unit);
    if (at == known.end()) return wrong("'" + model_.unit + "' is no unit of 3MF");
    model_.unit_mm = at->second;
    std::string_view needed = a.find("requiredextensions") == nullptr ? "" : a.find("requiredextensions");
    while (!needed.empty()) {
      const std::size_t space = needed.find(' ');
      const std::string prefix(needed.substr(0, space));
      needed.remove_prefix(space == needed.npos ? needed.size() : space + 1);
      if (prefix.empty()) continue;
      const std::string& address = addresses_[prefix];
      bool readable = false;
      for (const std::string_view one : kReadable) readable |= address == one;
      if (!readable)
        return wrong("the model requires the extension " + prefix + " (" + address + "), which is not read");
    }
    return {};
  }

  Result<void> group(const XmlAttributes& a) {
    const auto id = value<std::uint32_t>(a, "id");
    if (!id) return wrong("a group of materials without an id");
    group_ = *id, count_ = 0;
    return {};
  }
  Result<void> colour(std::string_view name, const XmlAttributes& a) {
    if (name == "colorgroup") return group(a);
    model_.materials.push_back({"", colour_of(text(a, "color"))});
    materials_[{group_, count_++}] = static_cast<std::uint32_t>(model_.materials.size());
    return {};
  }
  static std::optional<std::uint32_t> colour_of(const std::string& text) {
    std::uint32_t value = 0;
    if (text.size() < 7 || text[0] != '#') return std::nullopt;
    const auto [end, error] = std::from_chars(text.data() + 1, text.data() + 7, value, 16);
    return error == std::errc{} && end == text.data() + 7 ? std::optional(value) : std::nullopt;
  }
  std::uint32_t material(std::optional<std::uint32_t> of, std::optional<std::uint32_t> index) const {
    if (!of || !index) return 0;
    const auto at = materials_.find({*of, *index});
    return at == materials_.end() ? 0 : at->second;
  }

  Result<void> object(const XmlAttributes& a) {
    const auto id = value<std::uint32_t>(a, "id");
    if (!id) return wrong("an object without an id");
    id_ = *id;
    if (model_.objects.contains(id_)) return wrong(here() + " is there twice");
    object_ = &model_.objects[id_];
    object_->name = text(a, "name");
    if (const char* type = a.find("type")) object_->type = type;
    // It is known by others when it ends: what names it within itself is refused.
    usual_group_ = value<std::uint32_t>(a, "pid"), usual_index_ = value<std::uint32_t>(a, "pindex");
    return {};
  }

  Result<void> vertex(const XmlAttributes& a) {
    if (object_ == nullptr) return wrong("a vertex outside of an object");
    const auto x = value<double>(a, "x"), y = value<double>(a, "y"), z = value<double>(a, "z");
    if (!x || !y || !z)
      return wrong(here() + ", vertex " + std::to_string(object_->corners.size()) +
                   ": a coordinate is no number");
    object_->corners.push_back({*x, *y, *z});
    return {};
  }

  Result<void> triangle(const XmlAttributes& a) {
    if (object_ == nullptr) return wrong("a triangle outside of an object");
    const std::string place = here() + ", triangle " + std::to_string(object_->facets.size());
    std::array<std::uint32_t, 3> corners{};
    const char* const names[] = {"v1", "v2", "v3"};
    for (std::size_t i = 0; i < 3; ++i) {
      const auto corner = value<std::uint32_t>(a, names[i]);
      if (!corner || *corner >= object_->corners.size())
        return wrong(place + ": " + names[i] + " is " +
                     (a.find(names[i]) == nullptr ? "missing" : text(a, names[i])) + ", and there are " +
                     std::to_string(object_->corners.size()) + " vertices");
      corners[i] = *corner;
    }
    if (object_->facets.size() >= kMaxFacets)
      return fail(Code::kLimit, here() + ": over the limit of " + std::to_string(kMaxFacets) +
                                    " triangles; export with a coarser tolerance");
    object_->facets.push_back(corners);
    const bool own = a.find("p1") != nullptr;
    const auto of = a.find("pid") != nullptr ? value<std::uint32_t>(a, "pid") : usual_group_;
    object_->material.push_back(material(of, own ? value<std::uint32_t>(a, "p1") : usual_index_));
    return {};
  }

  Result<MfComponent> placed(const XmlAttributes& a, const std::string& what) {
    MfComponent placed;
    const auto id = value<std::uint32_t>(a, "objectid");
    if (a.find(std::string(kProduction) + "|path") != nullptr)
      return wrong(
          what + " names an object of another file of the archive (production extension), which is not read");
    if (!id || !model_.objects.contains(*id) || (object_ != nullptr && *id == id_))
      return wrong(what + " names object " + text(a, "objectid") + ", which is not there before it");
    placed.object = *id;
    const char* at = a.find("transform");
    if (at == nullptr) return placed;
    const char* const last = at + std::strlen(at);
    for (double& number : placed.transform) {
      while (at < last && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
      if (at < last && *at == '+') ++at;
      const auto [end, error] = std::from_chars(at, last, number);
      if (error != std::errc{} || !std::isfinite(number))
        return wrong(what + ": its transform is not twelve numbers");
      at = end;
    }
    while (at < last && *at == ' ') ++at;
    if (at != last) return wrong(what + ": its transform is not twelve numbers");
    return placed;
  }

  Result<void> component(const XmlAttributes& a) {
    if (object_ == nullptr) return wrong("a component outside of an object");
    auto one = placed(a, here() + ", component " + std::to_string(object_->components.size()));
    if (!one) return tl::unexpected(one.error());
    object_->components.push_back(*one);
    return {};
  }
  Result<void> item(const XmlAttributes& a) {
    auto one = placed(a, "build item " + std::to_string(model_.items.size()));
    if (!one) return tl::unexpected(one.error());
    model_.items.push_back(*one);
    return {};
  }

  MfModel& model_;
  std::map<std::string, std::string> addresses_;  ///< of prefixes
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> materials_;
  MfObject* object_ = nullptr;  ///< that is being read
  std::uint32_t id_ = 0, group_ = 0, count_ = 0;
  std::optional<std::uint32_t> usual_group_, usual_index_;
  bool found_ = false;
};

}  // namespace

Result<MfModel> read_mf_model(std::string_view xml, const std::string& file) {
  MfModel model;
  Elements elements(model);
  const XmlHandlers handlers{
      [&](std::string_view name, const XmlAttributes& a) { return elements.begin(name, a); },
      [&](std::string_view name) { return elements.end(name); },
      [&](std::string_view prefix, std::string_view address) { elements.names_space(prefix, address); }};
  if (auto done = walk_xml(xml, file, handlers); !done) return tl::unexpected(done.error());
  if (!elements.found_model()) return wrong(file + ": it has no model of 3MF");
  return model;
}

}  // namespace tiltfeed::pathgen
