#pragma once

#include <string>
#include <vector>

#include "apps/reports/report.h"

namespace relief {

/// What differs between the pages that the program writes.
struct PageParts {
  std::string title;                  ///< Plain text.
  std::string kind;                   ///< Of the page, in its title: `report`, `comparison`.
  std::vector<std::string> sections;  ///< Each a <section> of HTML, or empty.
  Json figures;                       ///< In the element `report`: what the numbers refer to.
  std::string exact;                  ///< Where the exact numbers are, as HTML.
  std::string credit;                 ///< HTML behind the last sentence of the page.
  std::string scripts;                ///< <script> elements at the end of the page.
};

/// The whole page, which needs no other file and no network.
std::string fill_page(const PageParts& parts);

}  // namespace relief
