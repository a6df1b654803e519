/* A device that somebody holds, from C: what is written to it goes through the safety chain. */
#include <kilotouch/kilotouch.h>
#include <math.h>
#include <stdio.h>

static double length(const double v[3]) { return sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

int main(void) {
  const char* settings[] = {"tool.path.device.name=pushed", "tool.path.device.max_force=0.1",
                            "tool.path.device.deadman=1"};
  kt_touch* touch = kt_open_mesh("meshes/block.msh", settings, sizeof settings / sizeof *settings);
  kt_pose pose = {sizeof(kt_pose), 0, {0.03, 0.026, 0.03}, {1, 0, 0, 0}};
  kt_device device = {sizeof(kt_device), 1, KT_DEVICE_OK, 0, 0, 0};
  kt_frame frame = {sizeof(kt_frame), 0};
  double most = 0, zero_after = -1;
  char told[2000];
  size_t needed;
  int i;
  if (!touch) {
    fprintf(stderr, "%s\n", kt_last_error());
    return 1;
  }
  if (kt_place(touch, &pose, 1) != KT_OK) return 1;
  for (i = 0; i < 1500; ++i) {
    /* Here you read your device: its pose, and how old that is. This one is unplugged after 1.2 s. */
    if (i < 1200) pose.x[2] = 0.03 - 0.008 * (i < 800 ? i / 800.0 : 1);
    device.age = i < 1200 ? 0 : 1e-3 * (i - 1199);
    if (kt_tick_device(touch, &pose, &device, 1, 1e-3, &frame) != KT_OK) return 1;
    /* And here you write frame.force to it. */
    if (length(frame.force) > most) most = length(frame.force);
    if (i >= 1200 && zero_after < 0 && length(frame.force) == 0) zero_after = device.age;
  }
  printf("at most %.4f N; zero %.0f ms after the last pose; gate %s\n", most, 1e3 * zero_after,
         frame.flags & KT_GATED ? "shut" : "open");
  if (kt_warnings(touch, told, sizeof told, &needed) != KT_OK || needed == 1) return 1; /* that it was unplugged */
  printf("%s", told);
  kt_close(touch);
  return 0;
}
