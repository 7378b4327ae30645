#include "config/blank.h"

#include "config/body_keys.h"
#include "config/enum_words.h"

namespace tiltfeed::config {
namespace {

constexpr Range kMargin{0.0, 1000.0};  // mm
constexpr Words<BlankShape> kBlankWords = {
    {"box", BlankShape::kBox}, {"cylinder", BlankShape::kCylinder}, {"file", BlankShape::kFile}};

}  // namespace

std::optional<Blank> read_blank(const Section& root, const std::string& path) {
  if (!root.has("blank")) return std::nullopt;
  const Section section = root.section("blank", {"shape", "margin_mm", "file", "unit"});
  Blank blank;
  blank.shape = section.choice<BlankShape>("shape", kBlankWords);
  if (blank.shape == BlankShape::kFile) {
    blank.path = beside_file(path, section.text("file"));
    blank.unit_mm = read_stl_unit(section);
    section.unused("margin_mm", "with the shape file, which is as large as it is");
    return blank;
  }
  blank.margin = section.number("margin_mm", kMargin, 0.0);
  for (const char* key : {"file", "unit"}) section.unused(key, "without the shape file");
  return blank;
}

void describe_blank(Description& out, const std::optional<Blank>& blank) {
  if (!blank) return out.add("blank", "none");
  out.add("blank.shape", word(kBlankWords, blank->shape));
  if (blank->shape != BlankShape::kFile) return out.add("blank.margin_mm", blank->margin);
  out.add("blank.file", blank->path);
  out.add("blank.unit_mm", blank->unit_mm);
}

}  // namespace tiltfeed::config
