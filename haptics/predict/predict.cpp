#include "haptics/predict/predict.hpp"

namespace kt {

std::vector<Prediction> predict_failures(const BuiltScene& built) {
  std::vector<Prediction> out;
#define PREDICTION(name) predict_##name(built, out);
#include "haptics/predict/predictions.def"
  return out;
}

}  // namespace kt
