#include "haptics/predict/predict.hpp"

namespace kt {

std::vector<Prediction> predict_failures(const Session& session) {
  std::vector<Prediction> out;
#define PREDICTION(name) predict_##name(session, out);
#include "haptics/predict/predictions.def"
#undef PREDICTION
  return out;
}

}  // namespace kt
