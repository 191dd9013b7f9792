import { DistributionView } from './distribution';
import { ImageView } from './images';
import { LabelsView } from './labels';
import { MatrixView } from './matrix';
import { ProfilesView } from './profiles';
import { RenderedView } from './rendered';
import { ParticlesView, ShapesView, useShapesOf, webGL } from './solids';
import { Summary } from './summary';
import { TableView } from './tables';
import { VolumeView } from './volumes';
import type { DocNode, OutputValue } from './types';

// Particles or shapes as a picture, and what is in them.
function Plain({ value, node }: { value: OutputValue; node: DocNode }) {
  const shapes = useShapesOf(node, value);
  return <div className="both"><RenderedView value={value} shapes={value.type === 'Particles' ? shapes : null} /><Summary value={value} /></div>;
}

export function View({ value, node }: { value: OutputValue; node: DocNode }) {
  switch (value.type) {
    case 'Image': return <ImageView value={value} node={node} />;
    case 'Labels': return <LabelsView value={value} node={node} />;
    case 'Profiles': return <ProfilesView value={value} node={node.name} />;
    case 'Table': return <TableView value={value} />;
    case 'SizeDistribution': return <DistributionView value={value} node={node} />;
    case 'KMatrix': return <MatrixView value={value} />;
    case 'Volume': return <VolumeView value={value} node={node} />;
    case 'Particles': return webGL ? <ParticlesView value={value} node={node} /> : <Plain value={value} node={node} />;
    case 'Shapes': return webGL ? <ShapesView value={value} node={node} /> : <Plain value={value} node={node} />;
    default: return <Summary value={value} />;
  }
}
