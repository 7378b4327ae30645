#include "cad/shape/document.h"

#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <TDocStd_Document.hxx>
#include <XCAFApp_Application.hxx>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "pathgen/mesh/stl_facets.h"

namespace tiltfeed::cad {

opencascade::handle<TDocStd_Document> new_document() {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  Interface_Static::SetCVal("xstep.cascade.unit", "MM");
  opencascade::handle<TDocStd_Document> document;
  XCAFApp_Application::GetApplication()->NewDocument("MDTV-XCAF", document);
  return document;
}

Result<std::string> file_text(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return fail(Code::kIo, path + ": cannot read: " + (error ? error.message() : "not a regular file"));
  const auto size = std::filesystem::file_size(path, error);
  if (error) return fail(Code::kIo, path + ": cannot read: " + error.message());
  if (size > pathgen::kMaxStlBytes)
    return fail(Code::kLimit, path + ": " + std::to_string(size) + " bytes are over the limit of " +
                                  std::to_string(pathgen::kMaxStlBytes) + "; export the bodies one by one");
  std::string text(size, '\0');
  std::ifstream in(path, std::ios::binary);
  if (!in.read(text.data(), static_cast<std::streamsize>(size)))
    return fail(Code::kIo, path + ": cannot read: " + std::strerror(errno));
  return text;
}

}  // namespace tiltfeed::cad
