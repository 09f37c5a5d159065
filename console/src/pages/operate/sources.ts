// Which values of a monitor are plotted.
import type { Quantity } from '../../units';

export type What = 'water' | 'currents';

export interface Source {
  id: string;
  subsystem: string;
  field: string;
  quantity: Quantity;
}

export const SOURCES: Record<What, Source[]> = {
  water: [
    { id: 'pressure', subsystem: 'General', field: 'pressure', quantity: 'pressure' },
    { id: 'flow', subsystem: 'General', field: 'flowrate', quantity: 'flow' },
  ],
  currents: [
    { id: 'Horizontal', subsystem: 'Horizontal', field: 'current', quantity: 'current' },
    { id: 'Vertical', subsystem: 'Vertical', field: 'current', quantity: 'current' },
    { id: 'Nozzle', subsystem: 'Nozzle', field: 'current', quantity: 'current' },
  ],
};
