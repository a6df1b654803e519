/* The C interface: open a mesh, tick, draw, change a setting, close. */
#include <kilotouch/kilotouch.h>
#include <stdio.h>
#include <stdlib.h>

int main(void) {
  const char* settings[] = {"contact.mu=0.3", "object.model.young=8000"};
  kt_touch* touch = kt_open_mesh("meshes/block.msh", settings, sizeof settings / sizeof *settings);
  kt_pose pose = {sizeof(kt_pose), 0, {0.03, 0.026, 0.03}, {1, 0, 0, 0}};
  kt_frame frame = {sizeof(kt_frame), 0};
  kt_stats stats = {sizeof(kt_stats), 0};
  size_t numbers = 0;
  float* xyz;
  int i;
  if (!touch) {
    fprintf(stderr, "%s\n", kt_last_error());
    return 1;
  }
  if (kt_place(touch, &pose, 1) != KT_OK) return 1;
  for (i = 0; i < 600; ++i) {
    pose.x[2] = 0.03 - 0.008 * (i < 400 ? i / 400.0 : 1);
    if (kt_tick(touch, &pose, 1, &frame) != KT_OK) return 1;
    if (i == 450 && kt_set_number(touch, "contact.mu", 0.1) != KT_OK) return 1;
  }
  if (kt_set_number(touch, "contact.mu", -1) == KT_OK) return 1;
  printf("refused: %s\n", kt_last_error());
  kt_positions(touch, NULL, 0, &numbers);
  xyz = malloc(numbers * sizeof(float));
  if (!xyz || kt_positions(touch, xyz, numbers, &numbers) != KT_OK) return 1;
  kt_stats_of(touch, &stats);
  printf("kilotouch %s: %.4f N, %d refreshes, %u numbers of positions\n", kt_version(), frame.f_n, (int)stats.refreshes,
         (unsigned)numbers);
  free(xyz);
  kt_close(touch);
  return 0;
}
