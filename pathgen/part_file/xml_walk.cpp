#include "pathgen/part_file/xml_walk.h"

#include <expat.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <type_traits>

namespace tiltfeed::pathgen {
namespace {

constexpr int kMostNested = 100;
constexpr std::size_t kPiece = 1 << 20;  // of the text: expat counts bytes in an int

struct XmlWalk {
  XML_Parser parser;
  const XmlHandlers& handlers;
  std::optional<Error> error;
  int depth = 0;

  void stop(Error why) {
    if (!error) error = std::move(why);
    ::XML_StopParser(parser, XML_FALSE);
  }
};

void begin_element(void* data, const char* name, const char** attributes) {
  auto& walk = *static_cast<XmlWalk*>(data);
  if (walk.error) return;
  if (++walk.depth > kMostNested) return walk.stop({Code::kInput, "elements lie too deep in each other"});
  if (auto done = walk.handlers.begin(name, XmlAttributes(attributes)); !done) walk.stop(done.error());
}
void end_element(void* data, const char* name) {
  auto& walk = *static_cast<XmlWalk*>(data);
  if (walk.error) return;
  --walk.depth;
  if (auto done = walk.handlers.end(name); !done) walk.stop(done.error());
}
void begin_doctype(void* data, const char*, const char*, const char*, int) {
  static_cast<XmlWalk*>(data)->stop({Code::kInput, "a document type is not allowed here"});
}
void begin_names(void* data, const char* prefix, const char* address) {
  const auto& walk = *static_cast<XmlWalk*>(data);
  if (walk.handlers.names_space)
    walk.handlers.names_space(prefix == nullptr ? "" : prefix, address == nullptr ? "" : address);
}

}  // namespace

const char* XmlAttributes::find(std::string_view name) const {
  for (const char** at = list_; *at != nullptr; at += 2)
    if (at[0] == name) return at[1];
  return nullptr;
}

Result<void> walk_xml(std::string_view text, const std::string& file, const XmlHandlers& handlers) {
  const std::unique_ptr<std::remove_pointer_t<XML_Parser>, void (*)(XML_Parser)> parser(
      ::XML_ParserCreateNS(nullptr, '|'), ::XML_ParserFree);
  if (!parser) return fail(Code::kLimit, file + ": no memory to read it");
  XmlWalk walk{parser.get(), handlers, {}, 0};
  ::XML_SetUserData(parser.get(), &walk);
  ::XML_SetElementHandler(parser.get(), begin_element, end_element);
  ::XML_SetStartDoctypeDeclHandler(parser.get(), begin_doctype);
  ::XML_SetStartNamespaceDeclHandler(parser.get(), begin_names);
  for (bool last = false; !last;) {
    const std::string_view piece = text.substr(0, kPiece);
    text.remove_prefix(piece.size());
    last = text.empty();
    if (::XML_Parse(parser.get(), piece.data(), static_cast<int>(piece.size()), last ? 1 : 0) ==
        XML_STATUS_OK)
      continue;
    const std::string place = file + ":" + std::to_string(::XML_GetCurrentLineNumber(parser.get())) + ": ";
    if (walk.error) return fail(walk.error->code, place + walk.error->message);
    return fail(Code::kInput,
                place + "the XML is damaged: " + ::XML_ErrorString(::XML_GetErrorCode(parser.get())) +
                    "; export or copy the part again");
  }
  return {};
}

}  // namespace tiltfeed::pathgen
