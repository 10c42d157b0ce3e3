#pragma once

#include <string>
#include <vector>

#include "relief/scan/result.h"
#include "scan/io/normals/normal_evidence.h"

namespace relief {

struct ChosenConvention {
  NormalConvention convention;
  /// False: even in this convention the normals contradict the depth, and are not to be used.
  bool usable = true;
};

struct ConventionChoice {
  std::vector<ChosenConvention> views;  ///< One for each evidence.
  std::vector<std::string> notes;       ///< What differs from the statements of the project.
};

/// Settles the conventions of all views with normals. The declared convention is kept unless
/// another one is clearly closer to the depth; where a view alone cannot tell, it follows the most
/// views of the same declaration that it does not contradict. Of several conventions that fit
/// equally, the one nearest to the declaration is taken. Normals that are more than 15 deg off
/// in the median even so, beyond the noise of the depth, are not usable. An image that is more than
/// 35 deg off does not belong to this depth: kBadInput where more images are than fit.
Result<ConventionChoice> choose_conventions(const std::vector<NormalEvidence>& views);

}  // namespace relief
